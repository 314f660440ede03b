"""Units, enumerations, types, transformations and parameter values: from checked XML to typed data."""

from __future__ import annotations

import binascii
from collections.abc import Callable, Mapping
from typing import TypeVar

from master.fmi.units import Unit
from master.fmi.value_types import NAMES, RANGES

from .grammar import REAL_TYPES, everywhere
from .markup import Node, boolean, double, integer
from .names import WHOLE_TYPES, ssc, ssm, ssv
from .structure import DataType, Given, Linear, Renaming, Scope, Table, Transformation

_EXPONENTS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
_WHOLE = {name: RANGES[NAMES.index(name)] for name in WHOLE_TYPES}

T = TypeVar("T")


def read_scope(root: Node, problems: list[str]) -> Scope:
    """Units and enumerations of a file."""
    units: dict[str, Unit] = {}
    enumerations: dict[str, Mapping[str, int]] = {}
    for node in root.children():
        if node.element.tag in everywhere("Units"):
            for one in node.children():
                _once(units, one, _unit(one, problems), problems)
        elif node.element.tag in everywhere("Enumerations"):
            for one in node.children():
                items: dict[str, int] = {}
                for item in one.children(ssc("Item")):
                    _once(items, item, integer(item.text("value")), problems)
                _once(enumerations, one, items, problems)
    return Scope(units, enumerations)


def _once(found: dict[str, T], node: Node, value: T, problems: list[str]) -> None:
    name = node.text("name")
    if name in found:
        problems.append(f"{node.where}: twice, expected one {node.tag} of a name")
    found[name] = value


def _unit(node: Node, problems: list[str]) -> Unit:
    base = node.child(ssc("BaseUnit"))
    name = node.text("name")
    if base is None:
        return Unit(name, defined=False)
    exponents = {key: integer(base.get(key) or "0") for key in _EXPONENTS}
    factor, offset = (double(base.get(key) or default) for key, default in (("factor", "1"), ("offset", "0")))
    if not (abs(factor) < float("inf") and factor and abs(offset) < float("inf")):
        problems.append(f"{node.where}: cannot be converted, got factor {factor:g} and offset {offset:g}")
        return Unit(name, defined=False)
    return Unit(name, {key: n for key, n in exponents.items() if n}, factor, offset)


def read_type(node: Node, scope: Scope, problems: list[str]) -> DataType | None:
    """Type of a connector or of an entry of a dictionary, None if it has none."""
    types = [one for one in node.children() if one.tag in _KIND_OF]
    clocks = [one for one in types if one.tag == "Clock" and len(types) > 1]  # a clock that it belongs to
    types = [one for one in types if one not in clocks]
    if clocks:
        problems.append(f"{node.where}: a clock is not understood, expected a connector without one")
    if not types:
        return None
    if len(types) > 1:
        problems.append(f"{node.where}: has {len(types)} types, expected one")
    found = types[0]
    items: Mapping[str, int] = {}
    if found.tag == "Enumeration":
        name = found.text("name")
        if name not in scope.enumerations:
            problems.append(f"{node.where}: no such enumeration in the file, got {name!r}")
        items = scope.enumerations.get(name, {})
    return DataType(_KIND_OF[found.tag], read_unit(found, scope), items)


_KIND_OF = {
    **dict.fromkeys(REAL_TYPES, "Real"),
    **dict.fromkeys(("Integer", *WHOLE_TYPES), "Integer"),
    **{name: name for name in ("Boolean", "String", "Enumeration", "Binary", "Clock")},
}


def read_unit(node: Node, scope: Scope) -> Unit | None:
    """Unit that an element names; one that the file does not define is known by its name alone."""
    name = node.get("unit")
    return None if name is None else scope.units.get(name, Unit(name, defined=False))


def read_transformation(node: Node, problems: list[str]) -> Transformation | None:
    """Transformation of a connection or of an entry of a mapping."""
    found = [one for one in node.children() if one.tag.endswith("Transformation")]
    if not found:
        return None
    one = found[0]
    if len(found) > 1:
        problems.append(f"{node.where}: has {len(found)} transformations, expected one")
    if one.tag == "LinearTransformation":
        factor, offset = double(one.get("factor") or "1"), double(one.get("offset") or "0")
        if not (abs(factor) < float("inf") and abs(offset) < float("inf")):
            problems.append(
                f"{one.where} in {node.tag}: not finite, got factor {factor:g} and offset {offset:g}"
            )
        return Linear(factor, offset, node.where)
    kind = one.tag.removesuffix("MappingTransformation")
    entries: dict[str, str] = {}
    for entry in one.children():
        try:
            source, target = (_normal(kind, entry.text(end)) for end in ("source", "target"))
        except ValueError as error:
            got = f"{entry.text('source')!r} to {entry.text('target')!r}"
            problems.append(f"{entry.where} in {one.tag}: not allowed, got {got}, {error}")
            continue
        if source in entries:
            problems.append(f"{entry.where} in {one.tag}: {source!r} is mapped twice, expected once")
        entries[source] = target
    return Table(kind, entries, node.where)


def _normal(kind: str, text: str) -> str:
    """One spelling of each value."""
    if kind == "Boolean":
        return str(int(boolean(text)))
    return str(integer(text)) if kind == "Integer" else text


def read_parameters(parameter_set: Node, outer: Scope, problems: list[str]) -> tuple[Given, ...]:
    """Values of a parameter set; units that it does not define are those of the file around it."""
    own = read_scope(parameter_set, problems)
    scope = Scope({**outer.units, **own.units}, {**outer.enumerations, **own.enumerations})
    found: dict[str, Given] = {}
    for node in parameter_set.children(f"{ssv('Parameters')}/{ssv('Parameter')}"):
        given = _given(node, scope, problems)
        if node.text("name") in found:
            problems.append(f"{node.where}: twice in the parameter set, expected one value of a name")
        if given is not None:
            found[given.name] = given
    return tuple(found.values())


def _given(node: Node, scope: Scope, problems: list[str]) -> Given | None:
    typed = [one for one in node.children() if one.tag in _KIND_OF and one.element.tag == ssv(one.tag)]
    if len(typed) != 1:
        problems.append(f"{node.where}: has {len(typed)} values, expected one")
        return None
    one = typed[0]
    shape = [d.get("size") for d in node.children(ssc("Dimension"))]
    if None in shape:
        problems.append(f"{node.where}: a size that a connector gives is not understood, expected a number")
        return None
    texts = [value.text("value") for value in one.children()]
    if one.tag in ("String", "Enumeration") and not texts and one.get("value") is None:
        problems.append(f"{one.where} of {node.text('name')}: value is missing, expected one")
        return None
    if texts and one.get("value") is not None:
        problems.append(f"{one.where} of {node.text('name')}: two values, expected an attribute or elements")
    if not texts:
        text = one.text("value")
        texts = text.split() if shape and one.tag not in ("String", "Enumeration") else [text]
    count = 1
    for size in shape:
        count *= int(size or 1)
    if len(texts) != count:
        problems.append(f"{node.where}: got {len(texts)} values, expected {count}")
        return None
    try:
        values = tuple(_VALUE_OF[one.tag](text) for text in texts)
    except ValueError as error:
        article = "an" if one.tag[0] in "EI" else "a"
        problems.append(f"{node.where}: not {article} {one.tag}, got {one.text('value')!r}, {error}")
        return None
    items: Mapping[str, int] = {}
    if one.tag == "Enumeration" and one.get("name") is not None:
        items = scope.enumerations.get(one.text("name"), {})
    return Given(node.text("name"), _KIND_OF[one.tag], values, read_unit(one, scope), items, node.where)


def _whole(name: str) -> Callable[[str], int]:
    least, largest = _WHOLE[name]
    return lambda text: integer(text, int(least), int(largest))


def _binary(text: str) -> str:
    binascii.unhexlify(text)
    return text


_VALUE_OF: dict[str, Callable[[str], float | int | bool | str]] = {
    **dict.fromkeys(REAL_TYPES, double),
    "Integer": integer,
    **{name: _whole(name) for name in WHOLE_TYPES},
    "Boolean": boolean,
    "String": str,
    "Enumeration": str,
    "Binary": _binary,
    "Clock": str,
}


def read_renamings(mapping: Node, problems: list[str]) -> tuple[Renaming, ...]:
    """Entries of a parameter mapping."""
    found: dict[str, Renaming] = {}
    for node in mapping.children(ssm("MappingEntry")):
        target = node.text("target")
        if target in found:
            problems.append(f"{node.where}: {target!r} is a target twice, expected one entry for it")
        found[target] = Renaming(
            source=node.text("source"),
            target=target,
            converts_units=not boolean(node.get("suppressUnitConversion") or "false"),
            transformation=read_transformation(node, problems),
            where=node.where,
        )
    return tuple(found.values())
