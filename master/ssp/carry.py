"""What becomes of a value on its way: units, types and transformations, step by step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from master.errors import expected
from master.fmi.units import Conversion, Unit, conversion

from .network import Edge, Network
from .structure import DataType, Linear, Table, Transformation

_WIDENS = {("Integer", "Real"), ("Boolean", "Integer"), ("Boolean", "Real")}
_WHOLE = ("Integer", "Enumeration")


@dataclass(frozen=True)
class Carried:
    """
    A conversion so far, and the type that its value has there; `kind` is None where nothing says it.

    `ambiguous` is set where a transformation acted in a unit that no connector names.
    """

    conversion: Conversion
    kind: str | None
    unit: Unit | None
    items: Mapping[str, int]
    ambiguous: bool = False


def carry(
    network: Network, path: Sequence[Edge], given: Carried | None = None, *, trusted: bool = False
) -> Carried:
    """
    Follow a value along a path of edges.

    Args:
        network: Where the edges are.
        path: From the source on.
        given: The value's type at the source; that of the connector where nothing is given.
        trusted: Whether types may differ, as they may where this project wrote the system.

    Raises:
        ValueError: `where: what` of the first step that cannot be done.
    """
    carried = given or start_from(network.types[path[0].source])
    for edge in path:
        try:
            target = network.types[edge.target]
            if not trusted:
                _refuse_other_type(carried, target, edge.transformation)
            step = edge.transformation
            carried = convert(carried, target, edge.converts_units, step, trusted=trusted)
        except ValueError as error:
            raise ValueError(f"{edge.where}: {error}") from None
    return carried


def start_from(data_type: DataType | None) -> Carried:
    """Begin with the type of the source."""
    found = data_type or DataType("")
    return Carried(Conversion(), found.kind or None, found.unit, found.items)


def _refuse_other_type(
    carried: Carried, target: DataType | None, transformation: Transformation | None
) -> None:
    if target is None or carried.kind is None:
        return
    source, kind = carried.kind, target.kind
    if "Binary" in (source, kind) or "Clock" in (source, kind):
        raise ValueError(f"cannot be exchanged, got {source} -> {kind}, expected numbers or truths")
    if source in _WHOLE and kind in (*_WHOLE, "Real"):
        differ = carried.items and target.items and dict(carried.items) != dict(target.items)
        if differ and transformation is None:
            raise ValueError(
                f"enumerations differ, got {', '.join(carried.items)} -> {', '.join(target.items)}, "
                "expected a mapping of their items"
            )
    elif source != kind and (source, kind) not in _WIDENS:
        raise ValueError(f"types differ, got {source} -> {kind}, expected the same")


def convert(
    carried: Carried,
    target: DataType | None,
    converts_units: bool,
    transformation: Transformation | None,
    *,
    trusted: bool = False,
) -> Carried:
    """
    Take one step: units first, then the transformation, which must fit the types unless it is `trusted`.

    Raises:
        ValueError: If the units are of different quantities, or the transformation is not for such values.
    """
    unit = None if target is None else target.unit
    found = carried
    if converts_units and unit is not None and carried.unit is not None:
        between = conversion(carried.unit, unit)
        if between is None:
            got = f"got {carried.unit.name} -> {unit.name}"
            raise ValueError(f"units differ, {got}, expected the same quantity or suppressUnitConversion")
        if carried.ambiguous and not between.is_identity:
            raise ValueError(
                "the unit of a transformed value is not known, got a connector without a unit before it, "
                f"expected {carried.unit.name} or {unit.name} there"
            )
        found = replace(found, conversion=carried.conversion.then(between))
    if transformation is not None:
        step = transformed(transformation, found, target, trusted=trusted)
        try:
            found = replace(found, conversion=found.conversion.then(step))
        except ValueError as error:
            raise ValueError(f"cannot be done, got {error}, expected it before") from None
    kept_unit = carried.unit if converts_units else None
    return replace(
        found,
        kind=carried.kind if target is None else target.kind,
        unit=kept_unit if unit is None else unit,
        items=carried.items if target is None or not target.items else target.items,
        ambiguous=unit is None and (carried.ambiguous or transformation is not None),
    )


def transformed(
    transformation: Transformation, source: Carried, target: DataType | None, *, trusted: bool = False
) -> Conversion:
    """
    Write a transformation as a conversion of numbers.

    Raises:
        ValueError: If it is not for the type of the value or the target.
    """
    kinds = [kind for kind in (source.kind, None if target is None else target.kind) if kind is not None]
    if isinstance(transformation, Linear):
        if kinds and kinds[-1] != "Real" and not trusted:
            raise ValueError(f"LinearTransformation is for Real alone, got {kinds[-1]}")
        return Conversion(transformation.factor, transformation.offset)
    allowed = {"Boolean": ("Boolean",), "Integer": _WHOLE, "Enumeration": ("Enumeration",)}[
        transformation.kind
    ]
    wrong = [kind for kind in kinds if kind not in allowed]
    if wrong:
        raise ValueError(
            f"{transformation.kind}MappingTransformation is for {' and '.join(allowed)} alone, got {wrong[0]}"
        )
    if transformation.kind == "Enumeration":
        return _enumerated(transformation, source.items, {} if target is None else target.items)
    numbers = {float(key): float(value) for key, value in transformation.entries.items()}
    return Conversion(table=tuple(sorted(numbers.items())))


def _enumerated(table: Table, source: Mapping[str, int], target: Mapping[str, int]) -> Conversion:
    numbers: dict[float, float] = {}
    for key, value in table.entries.items():
        for name, items, side in ((key, source, "source"), (value, target or source, "target")):
            if name not in items:
                raise ValueError(
                    f"no such item of the {side}'s enumeration, got {name!r}, {expected(name, items)}"
                )
        numbers[float(source[key])] = float((target or source)[value])
    return Conversion(table=tuple(sorted(numbers.items())))
