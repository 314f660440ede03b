"""
An FMU that is carried along as it is: an inner model whose functions call the FMU's own library.

Each instance has a model of its own, as it depends on the connections which variables are set and read.
"""

from __future__ import annotations

import hashlib
import math
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from master.errors import ConfigError, Problem
from master.fmi.description import Description, Kind, Variable
from master.fmi.platforms import FMI2_FOLDER, FMI3_FOLDER, LIBRARY_SUFFIX
from master.fmi.value_types import INT32, INT64, LONG, MOST_EXACT, UINT32, UINT64
from master.system.graph import Instance, System
from master.text.archive import Archive, ArchiveError

from .inner import InnerModel, Row
from .program_c import number, quoted

_ROLES = ("PARAMETER", "INPUT", "STATE", "OUTPUT")
_BEYOND_INT32 = (UINT32, INT64, UINT64)
_STRING = 12  # in C, after all types of numbers

_HEADER = """\
#ifndef {guard}
#define {guard}

#include "foreign.h"

typedef struct {{
    double values[{n_values}];
    int is_unchecked; /* its own code checks its parameters */
}} {p}Data;

typedef struct {p}Instance {{
    {p}Data now;
    bool is_preview_valid;
    char *name;
    void *environment;
    void (*log)(const struct {p}Instance *instance, const char *message);
    Foreign *foreign;
}} {p}Instance;

bool {p}open({p}Instance *instance, const char *resources, Text *message);
void {p}close({p}Instance *instance);
void {p}instance_reset({p}Instance *instance);
bool {p}enter_initialisation({p}Instance *instance, const char *function, double t0);
bool {p}exit_initialisation({p}Instance *instance, const char *function);
const {p}Data *{p}instance_readable({p}Instance *instance);
bool {p}set({p}Instance *instance, ForeignCell cell);
bool {p}instance_step({p}Instance *instance, double t, double h);
bool {p}save({p}Instance *instance);
bool {p}restore({p}Instance *instance);

#endif
"""

_FUNCTIONS = """\
static bool tell(const {p}Instance *instance, bool is_well) {{
    if (!is_well) {{
        instance->log(instance, foreign_said(instance->foreign));
    }}
    return is_well;
}}

bool {p}open({p}Instance *instance, const char *resources, Text *message) {{
    instance->foreign = foreign_open(&fmu, resources, message);
    return instance->foreign != NULL;
}}

void {p}close({p}Instance *instance) {{
    foreign_close(instance->foreign);
    instance->foreign = NULL;
}}

void {p}instance_reset({p}Instance *instance) {{
    memcpy(instance->now.values, first_values, sizeof first_values);
}}

bool {p}enter_initialisation({p}Instance *instance, const char *function, double t0) {{
    (void)function;
    return tell(instance, foreign_start(instance->foreign, instance->now.values, t0));
}}

bool {p}exit_initialisation({p}Instance *instance, const char *function) {{
    (void)function;
    return tell(instance, foreign_begin(instance->foreign, instance->now.values));
}}

const {p}Data *{p}instance_readable({p}Instance *instance) {{
    const bool is_well = foreign_read_sources(instance->foreign, instance->now.values);
    return tell(instance, is_well) ? &instance->now : NULL;
}}

bool {p}set({p}Instance *instance, ForeignCell cell) {{
    return tell(instance, foreign_set(instance->foreign, cell, instance->now.values));
}}

bool {p}instance_step({p}Instance *instance, double t, double h) {{
    return tell(instance, foreign_step(instance->foreign, instance->now.values, t, h));
}}

bool {p}save({p}Instance *instance) {{
    return tell(instance, foreign_save(instance->foreign, instance->now.values));
}}

bool {p}restore({p}Instance *instance) {{
    return tell(instance, foreign_restore(instance->foreign));
}}
"""


@dataclass(frozen=True)
class ForeignModel(InnerModel):
    """
    An FMU whose archive lies in the resources of the fused one.

    `folder` is its name there, `places` are those of its variables by name, `cells` those by value reference
    and type.
    """

    description: Description
    folder: str
    places: Mapping[str, int]
    cells: Mapping[tuple[int, int], int]

    @property
    def is_foreign(self) -> bool:
        """Yes."""
        return True

    def place(self, variable: Variable) -> int:
        """Place of a variable among the values."""
        return self.places[variable.name]

    def place_of(self, reference: int, value_type: int) -> int:
        """Place of what a setter or getter of a type knows by a value reference."""
        return self.cells[reference, value_type]

    def cell(self, variable: Variable) -> str:
        """Write a variable as an initialiser in C."""
        return f"{{{variable.reference}, {variable.value_type}, {self.place(variable)}}}"

    def archive(self) -> dict[str, bytes]:
        """
        Read all files of the FMU, by their paths in the fused one.

        Raises:
            ConfigError: If one cannot be read.
        """
        try:
            with Archive(self.description.path) as archive:
                return {f"resources/{self.folder}/{name}": archive.read(name) for name in archive.names}
        except (ArchiveError, OSError) as error:
            raise ConfigError([f"{self.description.path}: cannot be read: {error}"]) from None


def refusals(instance: Instance, system: System) -> list[Problem]:
    """Say what an instance whose FMU is carried along cannot have."""
    received, handed, sources = _wired(instance, system)
    wired = {**received, **handed, **sources}
    return [problem.at(f"fmus.{instance.name}") for problem in _problems(instance, wired)]


def _wired(instance: Instance, system: System) -> list[dict[str, Variable]]:
    """Variables by name that connections set, that inputs of the system set, and that connections read."""
    name = instance.name
    received = [w.target.variable for w in system.wires_into(name)]
    handed = [w.target.variable for w in system.inlets if w.target.instance == name]
    wires = (*system.wires, *system.outlets)
    sources = [w.source.variable for w in wires if w.source.instance == name]
    return [{v.name: v for v in variables} for variables in (received, handed, sources)]


def foreign_model(instance: Instance, system: System, prefix: str) -> ForeignModel:
    """Make the model of an instance whose FMU is carried along, and that has no `refusals`."""
    received, handed, sources = _wired(instance, system)
    wired = {*received, *handed, *sources}
    d = instance.description
    chosen = [(v, role) for v in d.variables if (role := _role(v, wired)) is not None]
    chosen.sort(key=lambda pair: _ROLES.index(pair[1]))
    variables = [v for v, _ in chosen]
    rows = tuple(_row(v, role) for v, role in chosen)
    model = ForeignModel(
        prefix=prefix,
        identifier="foreign",
        header="",
        source="",
        rows=rows,
        tables=(),
        description=d,
        folder=_folder(instance),
        places={v.name: i for i, v in enumerate(variables)},
        cells={(v.reference, v.value_type): i for i, v in reversed(list(enumerate(variables)))},
    )
    return _with_code(model, instance, list(received.values()), list(sources.values()), chosen)


def _problems(instance: Instance, wired: Mapping[str, Variable]) -> Iterable[Problem]:
    d = instance.description
    if not sys.platform.startswith("linux"):
        yield Problem(
            "is not of this project, and is loaded on Linux alone", got=sys.platform, expected="Linux"
        )
    for v in wired.values():
        if v.array is not None:
            yield Problem(
                "an array of an FMU that is carried along", got=v.name, expected="connections of scalars"
            )
    for name, value in instance.start.items():
        v = d.by_name[name]
        if v.array is not None or v.is_structural:
            yield Problem(
                "a start value of an array of an FMU that is carried along", got=v.name, expected="scalars"
            )
        elif v.value_type in LONG and not isinstance(value, str) and abs(value) > MOST_EXACT:
            yield Problem(
                "an integer that a double does not hold", got=v.name, expected=f"up to {MOST_EXACT}"
            )


def _role(v: Variable, wired: set[str]) -> str | None:
    """Role of a variable that is known of the FMU here; None for one that only the FMU knows."""
    if v.kind is Kind.STRING or v.array is not None or v.is_structural:
        return None
    if v.name in wired:
        return "INPUT" if v.causality == "input" else "STATE" if v.is_settable else "OUTPUT"
    if _is_hidden(v):
        return None
    if v.causality == "output":
        return "STATE" if v.is_settable else "OUTPUT"
    if v.alias_of is not None:
        return None
    return {"parameter": "PARAMETER", "input": "INPUT"}.get(v.causality)


def _row(v: Variable, role: str) -> Row:
    kind = "ENUMERATION" if v.items else v.kind.name
    start = v.start_value
    return Row(
        name=v.name,
        unit="" if v.unit_name == "1" else quoted(f" {v.unit_name}")[1:-1],
        role=role,
        type=kind,
        is_fixed=v.variability == "fixed",
        is_hidden=_is_hidden(v),
        start=float(start) if isinstance(start, float | int) and math.isfinite(start) else 0.0,
        rules="NULL",
        n_rules=0,
    )


def _is_hidden(v: Variable) -> bool:
    """Whether the fused FMU cannot show a variable, which a connection may need all the same."""
    if v.causality not in ("parameter", "input", "output") or v.variability == "constant":
        return True
    if isinstance(v.start_value, float) and not math.isfinite(v.start_value):
        return True  # the wrapper takes finite values alone
    if v.kind is not Kind.INTEGER or v.items or v.value_type == INT32:
        return False
    return v.value_type in _BEYOND_INT32 or v.is_settable  # shown and set as Int32


def _folder(instance: Instance) -> str:
    """Name of the folder of an FMU; instances that must not share a library have one each."""
    d = instance.description
    told = hashlib.sha256(d.path.read_bytes() if d.path.is_file() else str(d.path).encode())
    if not d.can_share_library:
        told.update(instance.name.encode())
    return f"{re.sub(r'[^A-Za-z0-9_]', '_', d.model_identifier)}_{told.hexdigest()[:12]}"


def _with_code(
    model: ForeignModel,
    instance: Instance,
    received: Sequence[Variable],
    sources: Sequence[Variable],
    chosen: Sequence[tuple[Variable, str]],
) -> ForeignModel:
    """Write header and source."""
    d = model.description
    prefix = model.prefix
    names = {v.name for v in received}
    is_open = {"PARAMETER": "tunable", "INPUT": None}
    opened = [
        v
        for v, role in chosen
        if role in is_open and v.name not in names and is_open[role] in (None, v.variability)
    ]
    shown = [v for v, role in chosen if role in ("STATE", "OUTPUT")]
    starts = _starts(model, instance, chosen, names)
    binaries = FMI2_FOLDER if d.version == 2 else FMI3_FOLDER
    fields = (
        quoted(instance.name),
        quoted(model.folder),
        quoted(f"binaries/{binaries}/{d.model_identifier}{LIBRARY_SUFFIX}"),
        quoted(d.token),
        str(d.version),
        _truth(d.once_per_process),
        _truth(d.can_get_and_set_state),
        "starts",
        str(len(starts)),
    )
    first_values = ", ".join(number(row.start) for row in model.rows)
    lists = {"received": received, "opened": opened, "sources": sources, "shown": shown}
    lines = [
        f'#include "{model.file}.h"',
        "",
        "#include <string.h>",
        "",
        f"static const double first_values[] = {{{first_values or '0.0'}}};",
        "static const ForeignStart starts[] = {",
        *(f"    {start}," for start in starts or ["{{0, 0, 0}, false, 0.0, NULL}"]),
        "};",
    ]
    for name, variables in lists.items():
        cells = ", ".join(map(model.cell, _by_type(variables))) or "{0, 0, 0}"
        lines.append(f"static const ForeignCell {name}[] = {{{cells}}};")
    lines += ["static const ForeignFmu fmu = {", *(f"    {field}," for field in fields)]
    lines += [f"    {{{name}, {len(variables)}}}," for name, variables in lists.items()]
    lines += ["};", "", _FUNCTIONS.format(p=prefix)]
    header = _HEADER.format(guard=f"{prefix}FOREIGN_H".upper(), p=prefix, n_values=max(len(model.rows), 1))
    return replace(model, header=header, source="\n".join(lines))


def _truth(is_true: bool) -> str:
    return "true" if is_true else "false"


def _by_type(variables: Sequence[Variable]) -> list[Variable]:
    """Variables of one type next to each other, which one call sets or gets."""
    types = list(dict.fromkeys(v.value_type for v in variables))
    return sorted(variables, key=lambda v: types.index(v.value_type))


def _starts(
    model: ForeignModel, instance: Instance, chosen: Sequence[tuple[Variable, str]], received: set[str]
) -> list[str]:
    """Start values in the order in which the system gives them, then those that an importer may change."""
    starts = []
    of_importer = {v.name for v, role in chosen if role != "OUTPUT" and v.name not in received}
    for name, value in instance.start.items():
        v = model.description.by_name[name]
        if isinstance(value, str):
            starts.append(f"{{{{{v.reference}, {_STRING}, -1}}, true, 0.0, {quoted(value)}}}")
            continue
        cell = model.cell(v) if name in of_importer else f"{{{v.reference}, {v.value_type}, -1}}"
        starts.append(f"{{{cell}, true, {number(float(value))}, NULL}}")
    for v, _ in chosen:
        if v.name in of_importer and v.name not in instance.start:
            own = number(model.rows[model.place(v)].start)
            starts.append(f"{{{model.cell(v)}, false, {own}, NULL}}")
    return starts
