"""All C files of a fused FMU: those of its inner FMUs, the schedule, and the wrapper of native FMUs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from importlib.resources import files

from master.system.graph import Port

from .c_text import without_functions
from .events_c import EventWriter
from .layout import Fused, FusedVariable, InnerVariable
from .program_c import TickWriter, number, plan, quoted, read
from .refusal import refuse_long_program
from .shared_c import fmi_headers, wrapper_sources
from .start_c import StartWriter

_NOT_OF_A_SYSTEM = (  # the parts of the wrapper that a system has in another form, or not at all
    "derivative.c",
    "equations.c",
    "integrate.c",
    "integrate.h",
    "step.c",
)
_OF_EVENTS = (
    "    Played played;",
    "    double channels[N_CHANNELS > 0 ? N_CHANNELS : 1][N_CHANNEL_COLUMNS];",
)
_OF_FMI = ("access.", "derivative.", "fmi2", "fmi3", "saved_state.", "step.")
_OF_A_MODEL = (
    "has_fault",
    "are_results_well",
    "refuse_faults",
    "check_faults",
    "refuse_result",
    "check_finite",
)


def sources(fused: Fused, token: str) -> dict[str, bytes]:
    """
    Generate all C files and headers.

    Args:
        fused: The system.
        token: GUID (FMI 2.0) and instantiation token (FMI 3.0) that instantiation checks.

    Raises:
        ConfigError: If the program of a tick is too long.
    """
    content = {name: text.encode() for name, text in _texts(fused, token).items()} | fmi_headers()
    return dict(sorted(content.items()))


def run_sources(fused: Fused, recorded: Sequence[Port]) -> dict[str, bytes]:
    """
    Generate all C files and headers of a library that makes whole runs, without the functions of FMI.

    Args:
        fused: The system.
        recorded: Outputs of FMUs, in the order of a row.

    Raises:
        ConfigError: If the program of a tick is too long.
    """
    texts = {n: text for n, text in _texts(fused, "").items() if not n.startswith(_OF_FMI)}
    texts |= _c_files("c_runs") | {"record.c": _record(fused, recorded), "recorded.h": _recorded(recorded)}
    return {name: text.encode() for name, text in sorted(texts.items())}


def _texts(fused: Fused, token: str) -> dict[str, str]:
    """All C files and headers but those of FMI itself."""
    texts = _wrapper() | _c_files("c")
    if fused.has_foreign:
        texts = _that_opens(texts) | _c_files("c_foreign")
    if fused.scenario.events:
        texts |= _c_files("c_events")
    for model in fused.models:
        texts[f"{model.file}.h"] = model.header
        texts[f"{model.file}.c"] = model.source
    program = plan(fused)
    refuse_long_program(program)
    writer = TickWriter(fused, program)
    events = EventWriter(fused, program.channel_of, program.place)
    texts["model_data.h"] = _sizes(fused, token)
    texts["model_variables.c"] = _tables(fused)
    texts["memory.h"] = _memory(fused, writer, events)
    texts["system.c"] = _system(fused, writer, events)
    return texts


def _wrapper() -> dict[str, str]:
    """The wrapper of a model, whose data hold the memory of a system too."""
    texts = {n: c.decode() for n, c in wrapper_sources().items() if n not in _NOT_OF_A_SYSTEM}
    instance = texts["instance.h"]
    instance = _once(instance, '#include "text.h"\n', '#include "text.h"\n\n#include "memory.h"\n')
    texts["instance.h"] = _once(instance, "} Data;", "    Memory memory;\n} Data;")
    texts["rules.c"] = without_functions(texts["rules.c"], [*_OF_A_MODEL, "check_results"])
    return texts


def _that_opens(texts: dict[str, str]) -> dict[str, str]:
    """The wrapper of a system that loads FMUs from its resources when it is instantiated."""
    found = dict(texts)
    for name in ("fmi2.c", "fmi3.c"):
        text = texts[name].replace("(void)resources, ", "", 1)  # of co-simulation, the first
        text = _once(text, '#include "access.h"\n', '#include "access.h"\n#include "opened.h"\n')
        own = "    instance->log = log_error;\n    return instance;\n"
        found[name] = _once(text, own, own.replace("instance;", "opened(instance, resources);"))
    header = '#include "equations.h"\n'
    text = _once(texts["instance.c"], header, f'{header}#include "opened.h"\n')
    freed = "        free(instance->name);\n"
    found["instance.c"] = _once(text, freed, f"        system_close(&instance->now.memory);\n{freed}")
    return found


def _once(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1, f"the wrapper has {old!r} not once"
    return text.replace(old, new)


def _c_files(name: str) -> dict[str, str]:
    folder = files("master.fuse") / name
    return {p.name: p.read_text(encoding="utf-8") for p in folder.iterdir() if p.name.endswith((".c", ".h"))}


def _sizes(fused: Fused, token: str) -> str:
    counts = {
        "N_PARAMETERS": len(fused.of_role("PARAMETER")),
        "N_INPUTS": len(fused.of_role("INPUT")),
        "N_STATES": len(fused.of_role("STATE")),
        "N_OUTPUTS": len(fused.of_role("OUTPUT")),
        "N_FAULTS": 0,
    }
    lines = [
        f"/* Generated from the system {_comment(fused.name)}; do not edit. */",
        "",
        "#ifndef MODEL_DATA_H",
        "#define MODEL_DATA_H",
        "",
        f"#define MODEL_GUID {quoted(token)}",
        f"#define STEP_SIZE {fused.grid.step_size!r} /* s */",
        "",
        "enum {",
        ",\n".join(f"    {name} = {count}" for name, count in counts.items()),
        "};",
        "",
        "#endif",
    ]
    return "\n".join(lines) + "\n"


def _tables(fused: Fused) -> str:
    """Variables with the rules of their models, and the lists that belong to them."""
    rules = [table for model in fused.models for table in model.tables]
    readable = [_type(v) if not v.row.is_hidden else "TYPE_NONE" for v in fused.variables]
    inputs = [_type(v) if v.role == "INPUT" else "TYPE_NONE" for v in fused.variables]
    lines = [
        f"/* Generated from the declarations in the FMUs of {_comment(fused.name)}; do not edit. */",
        "",
        "#include <stddef.h>",
        "",
        '#include "model.h"',
        "",
        *rules,
        "",
        "const Variable model_variables[] = {",
        *map(_row, fused.variables),
        "};",
        "",
        f"const unsigned char model_readable[] = {{{', '.join(readable)}}};",
        f"const unsigned char model_inputs[] = {{{', '.join(inputs)}}};",
    ]
    return "\n".join(lines) + "\n"


def _type(v: FusedVariable) -> str:
    return f"TYPE_{v.row.type}"


def _row(v: FusedVariable) -> str:
    row = v.row
    fields = (
        quoted(v.name),
        f'"{row.unit}"',
        f"ROLE_{v.role}",
        _type(v),
        str(row.is_fixed).lower(),
        str(row.is_hidden).lower(),
        number(v.start),
        v.inner.model.prefix + row.rules if isinstance(v, InnerVariable) and row.n_rules else "NULL",
        str(row.n_rules),
    )
    return f"    {{{', '.join(fields)}}},"


def _memory(fused: Fused, writer: TickWriter, events: EventWriter) -> str:
    """Type of all that a system holds; copied as bytes by whoever saves its state."""
    memory = writer.program.memory
    inners = fused.inners.values()
    has_events = bool(fused.scenario.events)
    lines = [
        f"/* Generated from the system {_comment(fused.name)}; do not edit. */",
        "",
        "#ifndef MEMORY_H",
        "#define MEMORY_H",
        "",
        "#include <stdint.h>",
        "",
        *(f'#include "{model.file}.h"' for model in fused.models),
        *(["", *events.sizes(), "", '#include "events.h"'] if has_events else []),
        *(["", *_sizes_of_foreign(fused)] if fused.has_foreign else []),
        "",
        "typedef struct {",
        *(f"    {i.model.prefix}Instance {i.member}; /* {_comment(i.name)} */" for i in inners),
        *(f"    {i.model.prefix}Data saved_{i.member};" for i in writer.saved),
        f"    double values[{max(memory.values.size, 1)}];",
        f"    double rings[{max(memory.rings.size, 1)}]; /* older values */",
        f"    int passes[{max(len(memory.loops), 1)}]; /* over iterated groups, in this tick */",
        *(_OF_EVENTS if has_events else []),
        "    uint64_t tick;",
        "    double t0; /* s */",
        "    Text message; /* what an inner FMU said is wrong */",
        "    bool has_failed;",
        "} Memory;",
        "",
        "#endif",
    ]
    return "\n".join(lines) + "\n"


def _sizes_of_foreign(fused: Fused) -> Iterator[str]:
    """How many FMUs are carried along, and whether all of them save their state."""
    n_foreign = sum(inner.model.is_foreign for inner in fused.inners.values())
    yield f"enum {{ N_FOREIGN = {n_foreign}, DO_FOREIGN_SAVE_STATE = {int(fused.saves_state)} }};"


def _system(fused: Fused, writer: TickWriter, events: EventWriter) -> str:
    """Write `system.c`."""
    lines = [
        f"/* Generated from the system {_comment(fused.name)}; do not edit. */",
        "",
        '#include "schedule.h"',
        *(['#include "opened.h"'] if fused.has_foreign else []),
        *(['#include "play.h"'] if fused.scenario.events else []),
        "",
    ]
    for model in fused.models:
        own = f"{model.prefix}Instance"
        lines += [
            f"static void {model.prefix}say(const {own} *inner, const char *text) {{",
            "    say(inner->environment, inner->name, text);",
            "}",
            "",
        ]
    if fused.has_foreign:
        lines += [*_opening(fused), ""]
    if fused.scenario.events:
        lines += [*events.tables(), ""]
    lines += [*writer.first_values(), ""]
    lines += [*StartWriter(fused, events).lines(), ""]
    lines += [*writer.steps(), *writer.tick()]
    return "\n".join(lines) + "\n"


def _opening(fused: Fused) -> Iterator[str]:
    """Load and free the FMUs that are carried along."""
    foreign = [inner for inner in fused.inners.values() if inner.model.is_foreign]
    yield "bool system_open(Memory *memory, const char *resources, Text *message) {"
    for inner in foreign:
        yield f"    if (!{inner.model.prefix}open(&memory->{inner.member}, resources, message)) {{"
        yield "        return false;"
        yield "    }"
    yield "    return true;"
    yield "}"
    yield ""
    yield "void system_close(Memory *memory) {"
    for inner in foreign:
        yield f"    {inner.model.prefix}close(&memory->{inner.member});"
    yield "}"
    yield ""
    yield "Foreign *system_foreign(const Memory *memory, int number) {"
    yield "    switch (number) {"
    for i, inner in enumerate(foreign[1:], 1):
        yield f"    case {i}:"
        yield f"        return memory->{inner.member}.foreign;"
    yield "    default:"
    yield f"        return memory->{foreign[0].member}.foreign;"
    yield "    }"
    yield "}"


def _recorded(recorded: Sequence[Port]) -> str:
    return f"#define N_RECORDED {len(recorded)}\n"


def _record(fused: Fused, recorded: Sequence[Port]) -> str:
    """Write `record.c`."""
    lines = ['#include "runs.h"', "", '#include "schedule.h"', ""]
    lines += ["void system_record(const Memory *memory, double *row) {", "    (void)memory, (void)row;"]
    for i, port in enumerate(recorded):
        inner = fused.inners[port.instance]
        cell = f"memory->{inner.member}.now.values[{inner.model.place(port.variable)}]"
        lines.append(f"    row[{i}] = {read(cell, port.variable.value_type, inner.model)};")
    return "\n".join([*lines, "}"]) + "\n"


def _comment(text: str) -> str:
    return text.replace("*/", "* /").replace("\n", " ")
