"""
The sources of an FMU of this project as one header and one C file, with names of their own.

An FMU brings them in `sources/`: the wrapper, which is the same in all of them, and what is generated from
its model. Names get a prefix, so that any number of models are linked to one library.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from master.fmi.description import Description, Variable
from master.text.archive import Archive, ArchiveError

from .c_text import declared_names, joined, with_prefix, without_functions
from .prepared import Row as MovedRow
from .prepared import with_prepared
from .shared_c import wrapper_sources

_GENERATED = ("model_data.h", "model_variables.c", "model_equations.c")
_HEADERS = (
    "model_data.h",
    "model.h",
    "text.h",
    "instance.h",
    "equations.h",
    "integrate.h",
    "rules.h",
    "step.h",
    "lifecycle.h",
)
_SOURCES = (
    "model_variables.c",
    "model_equations.c",
    "text.c",
    "instance.c",
    "equations.c",
    "integrate.c",
    "rules.c",
    "step.c",
    "lifecycle.c",
)
MOST_INLINE = 200  # operations: the integration has four copies of them

_COUNT = re.compile(r"^    (N_\w+) = (\d+)", re.MULTILINE)
_ROW = re.compile(
    r'^    \{"(?P<name>(?:\\.|[^"\\])*)", "(?P<unit>(?:\\.|[^"\\])*)", '
    r"ROLE_(?P<role>\w+), TYPE_(?P<type>\w+), "
    r"(?P<fixed>true|false), (?P<hidden>true|false), (?P<start>[^,]+), (?P<rules>rules_\d+|NULL), "
    r"(?P<n_rules>\d+)\},$",
    re.MULTILINE,
)
_RULE_TABLE = re.compile(r"^static const (?:double items|Rule rules)_\d+\[\] = .*;$", re.MULTILINE)


class NoSourcesError(Exception):
    """An FMU whose sources cannot be compiled with others; the text says what is wrong with it."""


@dataclass(frozen=True)
class Row:
    """One variable as the C table of its model has it; `rules` names a table of `n_rules`, or is NULL."""

    name: str
    unit: str
    role: str
    type: str
    is_fixed: bool
    is_hidden: bool
    start: float
    rules: str
    n_rules: int


@dataclass(frozen=True)
class InnerModel:
    """
    The sources of one FMU; all that they declare begins with `prefix`.

    `rows` are its variables, a variable's place being its value reference in the FMU. `tables` are the rules
    that rows name, with prefix.
    """

    prefix: str
    identifier: str
    header: str
    source: str
    rows: tuple[Row, ...]
    tables: tuple[str, ...]

    @cached_property
    def file(self) -> str:
        """Name of its C file without the ending."""
        return f"{self.prefix}{self.identifier}"

    @property
    def is_foreign(self) -> bool:
        """Whether it is an FMU that is carried along as it is."""
        return False

    def place(self, variable: Variable) -> int:
        """Place of a variable among the values."""
        return variable.reference

    def place_of(self, reference: int, value_type: int) -> int:
        """Place of what a setter or getter of a type knows by a value reference."""
        return reference

    def first(self, role: str) -> int:
        """Place of the first variable of a role, or where it would be."""
        before = ("PARAMETER", "INPUT", "STATE", "OUTPUT")
        return sum(row.role in before[: before.index(role)] for row in self.rows)


def source_files(description: Description) -> dict[str, str]:
    """
    Read the C files inside an FMU.

    Raises:
        NoSourcesError: If it has none, or others than those that this version of the project writes.
    """
    if not description.keeps_float_mode:
        tool = f"an FMU of {description.tool}" if description.tool else "an FMU that names no tool"
        raise NoSourcesError(f"{tool}, whose sources are not known to this project or missing")
    try:
        with Archive(description.path) as archive:
            found = {name: archive.read(name) for name in archive.names if name.startswith("sources/")}
    except ArchiveError as error:
        raise NoSourcesError(str(error)) from None
    files = {name.removeprefix("sources/"): content for name, content in found.items()}
    wrapper = wrapper_sources()
    others = [name for name, content in wrapper.items() if files.get(name) != content]
    missing = [name for name in _GENERATED if name not in files]
    if missing or others:
        what = f"{', '.join([*missing, *others][:5])} missing or of another version"
        raise NoSourcesError(f"{what} in its sources; `dockloop build` makes it again")
    wanted = {*_HEADERS, *_SOURCES}
    return {name: content.decode() for name, content in files.items() if name in wanted}


def digest(files: Mapping[str, str]) -> str:
    """Digest by which models are told apart."""
    return hashlib.sha256("\0".join(f"{name}\0{files[name]}" for name in sorted(files)).encode()).hexdigest()


def inner_model(files: Mapping[str, str], identifier: str, prefix: str) -> InnerModel:
    """
    Join the C files of a model and put a prefix before all that they declare.

    Raises:
        NoSourcesError: If they are not as this project writes them.
    """
    try:
        return _inner_model(files, identifier, prefix)
    except ValueError as error:
        raise NoSourcesError(f"sources that are not as this project writes them ({error})") from None


def _inner_model(files: Mapping[str, str], identifier: str, prefix: str) -> InnerModel:
    rows = _rows(files)
    equations = with_prepared(files["model_equations.c"])
    changed = dict(files) | {"model_equations.c": _own_functions(equations.text)}
    changed["model_data.h"] = _replaced(
        files["model_data.h"], "    N_FAULTS =", f"    N_PREPARED = {equations.n_prepared},\n    N_FAULTS ="
    )
    prototypes = re.compile(
        r"^(?:/\* [^*]*\*/\n|/\*(?:(?!\*/).)*\*/\n)?void model_\w+\(.*?\);\n", re.M | re.S
    )
    changed["model.h"] = _replaced(
        prototypes.sub("", files["model.h"]),
        "extern const int model_restarting[];",
        "void model_prepare(const double *p, double *prepared); /* what depends on parameters alone */\n\n"
        "extern const int model_restarting[];",
    )
    changed["instance.h"] = _replaced(
        files["instance.h"],
        "} Data;",
        "    double prepared[ROOM(N_PREPARED)]; /* what depends on parameters alone */\n} Data;",
    )
    changed["rules.c"] = _replaced(
        files["rules.c"],
        "    data->is_unchecked = 0;\n",
        "    data->is_unchecked = 0;\n    model_prepare(data->values, data->prepared);\n",
    )
    changed["lifecycle.c"] = without_functions(files["lifecycle.c"], ["instantiation_problem"])
    if equations.moved is not None:
        changed["equations.c"] = _with_row_moved(files["equations.c"], equations.moved)
    changed["instance.c"] = without_functions(files["instance.c"], ["instance_create", "instance_free"])
    header = joined(changed[name] for name in _HEADERS)
    source = joined(changed[name] for name in _SOURCES)
    names = declared_names(header) | declared_names(source)
    prefixed = f'#include "{prefix}{identifier}.h"\n\n' + with_prefix(source, names, prefix)
    tables = tuple(_RULE_TABLE.findall(files["model_variables.c"]))
    return InnerModel(
        prefix=prefix,
        identifier=identifier,
        header=with_prefix(header, names, prefix),
        source=prefixed,
        rows=rows,
        tables=tuple(_table_with_prefix(table, prefix) for table in tables),
    )


def _replaced(text: str, old: str, new: str) -> str:
    """Replace a text that is there once."""
    if text.count(old) != 1:
        raise ValueError(f"not once in a file: {old.strip()!r}")
    return text.replace(old, new)


def _rows(files: Mapping[str, str]) -> tuple[Row, ...]:
    counts = {name: int(number) for name, number in _COUNT.findall(files["model_data.h"])}
    expected = sum(counts[name] for name in ("N_PARAMETERS", "N_INPUTS", "N_STATES", "N_OUTPUTS"))
    rows = tuple(
        Row(
            name=found["name"],
            unit=found["unit"],
            role=found["role"],
            type=found["type"],
            is_fixed=found["fixed"] == "true",
            is_hidden=found["hidden"] == "true",
            start=float(found["start"]),
            rules=found["rules"],
            n_rules=int(found["n_rules"]),
        )
        for found in _ROW.finditer(files["model_variables.c"])
    )
    if len(rows) != expected:
        raise ValueError(f"{len(rows)} variables in its table, {expected} in its sizes")
    return rows


def _table_with_prefix(table: str, prefix: str) -> str:
    return with_prefix(table, set(re.findall(r"\b(?:items|rules)_\d+\b", table)), prefix)


def _own_functions(equations: str) -> str:
    """Let equations be of their file alone; derivatives of few operations stand where they are used."""
    text = re.sub(r"^void (model_(?!prepare)\w+\()", r"static inline void \1", equations, flags=re.MULTILINE)
    body = equations[equations.index("void model_derivatives(") :].partition("\n}\n")[0]
    if body.count("const double a") > MOST_INLINE:
        return text
    attribute = "#if defined(__GNUC__)\n__attribute__((always_inline))\n#endif\n"
    return text.replace(
        "static inline void model_derivatives(", attribute + "static inline void model_derivatives("
    )


def _with_row_moved(equations: str, row: MovedRow) -> str:
    """Let an update move a row of states in their place."""
    after = row.first + row.n
    update = f"""\
void apply_update(Data *data, double t) {{
    double *x = data->values + FIRST_STATE;
    double new_x[ROOM(N_STATES)];
    model_update(t, x, data->values + FIRST_INPUT, data->values, new_x);
    memmove(x + {row.first}, x + {row.first + row.shift}, {row.n} * sizeof *x);
    memcpy(x, new_x, {row.first} * sizeof *x);
    memcpy(x + {after}, new_x + {after}, (N_STATES - {after}) * sizeof *x);
}}
"""
    return without_functions(equations, ["apply_update"]) + "\n" + update
