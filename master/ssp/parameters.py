"""Parameter bindings: which value reaches which variable, from the innermost element to the outermost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from master.errors import expected
from master.fmi.units import Conversion

from .carry import Carried, convert
from .network import Network, Path, Point, type_of, variable_of
from .structure import Binding, Component, DataType, Given, Renaming, SubSystem, Table

Scalar = float | int | bool | str


@dataclass(frozen=True)
class Bound:
    """A value, or the elements of an array, with its type at the connector or variable that it is for."""

    values: tuple[Scalar, ...]
    type: Carried
    where: str


@dataclass
class Assignments:
    """Values by connector or variable; `notes` says what reaches nothing."""

    values: dict[Point, Bound]
    notes: list[str]
    problems: list[str]


def assign(network: Network, system: SubSystem) -> Assignments:
    """Apply all bindings; those of an outer element come later and so over the inner ones."""
    found = Assignments({}, [], [])
    _assign(network, system, (), found)
    return found


def _assign(network: Network, element: SubSystem | Component, path: Path, found: Assignments) -> None:
    if isinstance(element, SubSystem):
        for name, inner in element.elements.items():
            if isinstance(inner, SubSystem | Component):
                _assign(network, inner, (*path, name), found)
    for binding in element.bindings:
        _apply(network, element, path, binding, found)


def _apply(
    network: Network, element: SubSystem | Component, path: Path, binding: Binding, found: Assignments
) -> None:
    unused = []
    for given, name, renaming in _named(binding, found):
        targets = list(_targets(element, path, name))
        if not targets:
            unused.append(name)
        for point in targets:
            where = given.where if renaming is None else renaming.where
            try:
                found.values[point] = _fit(given, renaming, _type_at(network, point))
            except ValueError as error:
                found.problems.append(f"{where}: {error}")
    if unused:
        listed = ", ".join(unused[:20]) + (", ..." if len(unused) > 20 else "")
        found.notes.append(f"{binding.where}: no variable takes these values: {listed}")


def _named(binding: Binding, found: Assignments) -> Iterator[tuple[Given, str, Renaming | None]]:
    """Values with the names that they are applied to; a mapping applies those alone that it names."""
    by_name = {binding.prefix + given.name: given for given in binding.values}
    if binding.renamings is None:
        for name, given in by_name.items():
            yield given, name, None
        return
    for renaming in binding.renamings:
        if renaming.source in by_name:
            yield by_name[renaming.source], renaming.target, renaming
        else:
            found.notes.append(f"{renaming.where}: no such value in the parameter set: {renaming.source}")
    used = {renaming.source for renaming in binding.renamings}
    left = [name for name in by_name if name not in used]
    if left:
        found.notes.append(f"{binding.where}: not in the mapping and so not used: {', '.join(left[:20])}")


def _targets(element: SubSystem | Component, path: Path, name: str) -> Iterator[Point]:
    """All connectors and variables that a hierarchical name may mean."""
    if isinstance(element, Component):
        fmu = element.fmu
        if variable_of(fmu, name) is not None or name in fmu.not_exchanged:
            yield Point(path, name)
        return
    if name in element.connectors:
        yield Point(path, name)
    for inner_name, inner in element.elements.items():
        if name.startswith(f"{inner_name}.") and isinstance(inner, SubSystem | Component):
            yield from _targets(inner, (*path, inner_name), name.removeprefix(f"{inner_name}."))


def _type_at(network: Network, point: Point) -> DataType | None:
    leaf = network.leaves.get(point.owner)
    if leaf is None:
        return network.types[point]
    variable = variable_of(leaf.component.fmu, point.connector)
    if variable is None:
        what = leaf.component.fmu.not_exchanged[point.connector]
        raise ValueError(f"{point} cannot be set, got {what}")
    return type_of(variable, leaf.component.connectors.get(point.connector))


def _fit(given: Given, renaming: Renaming | None, target: DataType | None) -> Bound:
    """Turn a value into what its target takes; ValueError if it cannot be."""
    if given.kind in ("Binary", "Clock"):
        raise ValueError(f"a value of type {given.kind} is not understood")
    source = Carried(Conversion(), given.kind, given.unit, given.items)
    transformation = None if renaming is None else renaming.transformation
    values: tuple[Scalar, ...] = given.values
    if isinstance(transformation, Table) and transformation.kind == "Enumeration":
        if given.kind != "Enumeration":
            raise ValueError(f"EnumerationMappingTransformation is for Enumeration alone, got {given.kind}")
        values = tuple(transformation.entries.get(str(value), str(value)) for value in values)
        transformation = None
        source = replace(source, items={} if target is None else target.items)
    elif given.kind == "Enumeration" and (transformation is not None or not _takes_items(target)):
        values = tuple(_number_of(str(value), given.items) for value in values)
        source = replace(source, kind="Integer")
    converts = renaming is None or renaming.converts_units
    if target is not None:
        _refuse_other_type(source, target)
    carried = convert(source, target, converts, transformation)
    return Bound(through(values, carried), replace(carried, conversion=Conversion()), given.where)


def through(values: tuple[Scalar, ...], carried: Carried) -> tuple[Scalar, ...]:
    """Convert values; ValueError for a text that would have to be a number."""
    change = carried.conversion
    if change.is_identity:
        return values
    return tuple(_converted(value, carried) for value in values)


def _converted(value: Scalar, carried: Carried) -> Scalar:
    if isinstance(value, str):
        value = _number_of(value, carried.items)
    result = carried.conversion.of(float(value))
    if carried.kind == "Boolean":
        return bool(result)
    return int(result) if carried.kind in ("Integer", "Enumeration") and result.is_integer() else result


def _number_of(text: str, items: Mapping[str, int]) -> int:
    if text in items:
        return items[text]
    if text.lstrip("-").isdigit():
        return int(text)
    raise ValueError(f"the number of item {text!r} is not known, {expected(text, items)}")


def _takes_items(target: DataType | None) -> bool:
    return target is None or target.kind == "Enumeration"


_FITS = {
    "Real": ("Real", "Integer", "Enumeration"),
    "Integer": ("Real", "Integer", "Enumeration"),
    "Boolean": ("Boolean",),
    "String": ("String",),
    "Enumeration": ("Enumeration", "Integer"),
}


def _refuse_other_type(source: Carried, target: DataType) -> None:
    allowed = _FITS.get(source.kind or "", ())
    if target.kind not in allowed:
        raise ValueError(f"types differ, got {source.kind}, expected {target.kind}")
