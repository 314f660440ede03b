"""The declarations of a model as C: sizes and places in `model_data.h`, variables and rules as tables."""

from __future__ import annotations

from collections.abc import Sequence

from ...framework.integrate import MOST_SAMPLES, MOST_SUBSTEPS
from ...framework.model import Model
from ...framework.variables import Role, Variable


def header(model: Model, guid: str) -> str:
    """Write `model_data.h`."""
    sizes = {
        "N_PARAMETERS": len(model.parameters),
        "N_INPUTS": len(model.inputs),
        "N_STATES": len(model.states),
        "N_CONTINUOUS": model.n_continuous,
        "N_OUTPUTS": len(model.results),
        "N_FAULTS": len(model.fault_texts),
        "N_RESTARTING": len(_restarting(model)),
        "SAMPLE_TIME": _place(model, model.sample_time),
        "INPUT_HOLD": _place(model, model.input_hold),
        "MOST_SAMPLES": MOST_SAMPLES,
        "MOST_SUBSTEPS": MOST_SUBSTEPS,
    }
    lines = [
        f"/* Generated from the model {model.name}; do not edit. */",
        "",
        "#ifndef MODEL_DATA_H",
        "#define MODEL_DATA_H",
        "",
        f"#define MODEL_GUID {quoted(guid)}",
        f"#define LONGEST_SUBSTEP {float(model.substep)!r}",
        "",
        "/* Counts; the places of two parameters, -1 for none; limits of a communication step. */",
        "enum {",
        ",\n".join(f"    {name} = {value}" for name, value in sizes.items()),
        "};",
        "",
        "#endif",
    ]
    return "\n".join(lines) + "\n"


def tables(model: Model) -> str:
    """Write `model_variables` with the rules, and the lists that belong to it."""
    rules: list[str] = []
    rows = []
    for i, v in enumerate(model.all_variables):
        found = _rules(i, v)
        rules += _rule_tables(i, v, found)
        rows.append(_row(i, v, len(found)))
    lines = [*rules, "", "const Variable model_variables[] = {", *rows, "};", "", *_type_tables(model), ""]
    places = ", ".join(map(str, _restarting(model))) or "0"
    lines += [*_fault_table(model), "", f"const int model_restarting[] = {{{places}}};"]
    return "\n".join(lines) + "\n"


def _type_tables(model: Model) -> list[str]:
    readable = [_type(v) if not v.hidden else "TYPE_NONE" for v in model.all_variables]
    inputs = [_type(v) if v.role is Role.INPUT else "TYPE_NONE" for v in model.all_variables]
    return [
        f"const unsigned char {name}[] = {{{', '.join(types)}}};"
        for name, types in (("model_readable", readable), ("model_inputs", inputs))
    ]


def _restarting(model: Model) -> list[int]:
    return [i for i, v in enumerate(model.all_variables) if v.restarts]


def _fault_table(model: Model) -> list[str]:
    places = {v.name: i for i, v in enumerate(model.all_variables)}
    rows = [
        f"    {{{places[f.variable]}, {quoted(f.text)}, {quoted(f.expected)}}}," for f in model.fault_texts
    ]
    return ["const Fault model_fault_texts[] = {", *(rows or ["    {0, NULL, NULL},"]), "};"]


def quoted(text: str) -> str:
    """Write a C string of printable ASCII and UTF-8."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _place(model: Model, name: str | None) -> int:
    return -1 if name is None else model.parameters.names.index(name)


def _rules(i: int, v: Variable) -> Sequence[str]:
    """Rules in the order in which `Variable.broken_rule` looks at them."""
    found = []
    if v.items is not None:
        text = "one of " + ", ".join(f"{item.value} ({item.name})" for item in v.items)
        found.append(f"{{RULE_ONE_OF, 0.0, items_{i}, {len(v.items)}, {quoted(text)}}}")
    bounds = (
        ("ABOVE", "above", v.above),
        ("AT_LEAST", "at least", v.minimum),
        ("AT_MOST", "at most", v.maximum),
    )
    for kind, words, bound in bounds:
        if bound is not None:
            text = quoted(f"{words} {bound!r}")
            found.append(f"{{RULE_{kind}, {float(bound)!r}, NULL, 0, {text}}}")
    return found


def _rule_tables(i: int, v: Variable, rules: Sequence[str]) -> list[str]:
    lines = []
    if v.items is not None:
        items = ", ".join(repr(float(item)) for item in v.items)
        lines.append(f"static const double items_{i}[] = {{{items}}};")
    if rules:
        lines.append(f"static const Rule rules_{i}[] = {{{', '.join(rules)}}};")
    return lines


def _type(v: Variable) -> str:
    if v.items is not None:
        return "TYPE_ENUMERATION"
    return "TYPE_BOOLEAN" if v.boolean else "TYPE_INTEGER" if v.integer else "TYPE_REAL"


def _row(i: int, v: Variable, n_rules: int) -> str:
    fields = (
        quoted(v.name),
        quoted("" if v.unit == "1" else f" {v.unit}"),
        f"ROLE_{v.role.name}",
        _type(v),
        str(v.fixed).lower(),
        str(v.hidden).lower(),
        repr(float(v.start)),
        f"rules_{i}" if n_rules else "NULL",
        str(n_rules),
    )
    return f"    {{{', '.join(fields)}}},"
