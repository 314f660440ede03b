"""Units: which a variable has, whether two are the same quantity, how a value goes from one to the other."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any
from xml.etree import ElementTree as ET


@dataclass(frozen=True)
class Unit:
    """A unit as FMI defines it: value in SI = factor * value + offset, with SI exponents."""

    name: str
    exponents: Mapping[str, int] = field(default_factory=dict)
    factor: float = 1.0
    offset: float = 0.0
    defined: bool = True


@dataclass(frozen=True)
class Conversion:
    """
    Value at the target = factor * m(value at the source) + offset.

    m takes a value that is a key of `table` to the value next to it and keeps every other.
    """

    factor: float = 1.0
    offset: float = 0.0
    table: tuple[tuple[float, float], ...] = ()

    @property
    def is_identity(self) -> bool:
        """Whether nothing changes."""
        return self.is_affine and self.factor == 1.0 and self.offset == 0.0

    @property
    def is_affine(self) -> bool:
        """Whether there is no table."""
        return not self.table

    def of(self, value: float) -> float:
        """Convert one value."""
        mapped = dict(self.table).get(value, value)
        return self.factor * mapped + self.offset

    def then(self, later: Conversion) -> Conversion:
        """
        Join this conversion with one that follows it.

        Raises:
            ValueError: If a table follows a factor or an offset.
        """
        if self.is_identity:
            return later
        if later.is_affine:
            factor = later.factor * self.factor
            return Conversion(factor, later.factor * self.offset + later.offset, self.table)
        if (self.factor, self.offset) != (1.0, 0.0):
            raise ValueError("a mapping after a linear transformation")
        first, second = dict(self.table), dict(later.table)
        table = second | {key: second.get(value, value) for key, value in first.items()}
        return Conversion(later.factor, later.offset, tuple(sorted(table.items())))


def conversion(source: Unit | None, target: Unit | None) -> Conversion | None:
    """
    Give the exact conversion between two units, or None if they are different quantities.

    A missing unit fits every unit; a unit that its FMU names without defining it fits the same name only.
    """
    if source is None or target is None:
        return Conversion()
    if not (source.defined and target.defined):
        return Conversion() if source.name == target.name else None
    if source.exponents != target.exponents:
        return None
    if (source.factor, source.offset) == (target.factor, target.offset):
        return Conversion()
    return Conversion(source.factor / target.factor, (source.offset - target.offset) / target.factor)


def units_of(model: Any, root: ET.Element) -> dict[str, Unit]:
    """Unit of each variable that has one; `model` is FMPy's description, `root` the XML."""
    units = {u.name: _unit(u) for u in model.unitDefinitions}
    relative = _relative(root)
    found = {}
    for v in model.modelVariables:
        name = v.unit or (v.declaredType.unit if v.declaredType is not None else None)
        if name:
            unit = units.get(name, Unit(name, defined=False))
            found[v.name] = replace(unit, offset=0.0) if v.name in relative else unit
    return found


def _relative(root: ET.Element) -> set[str]:
    """Variables that are differences, of temperatures for example: their unit's offset is not theirs."""

    def is_relative(e: ET.Element) -> bool:
        return e.get("relativeQuantity") in ("true", "1")

    types = {e.get("name") for e in root.iterfind("TypeDefinitions/*") if any(map(is_relative, (e, *e)))}
    return {
        e.get("name", "")
        for e in root.iterfind("ModelVariables/*")
        if any(is_relative(part) or part.get("declaredType") in types for part in (e, *e))
    }


_EXPONENTS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


def _unit(u: Any) -> Unit:
    base = u.baseUnit
    if base is None:
        return Unit(u.name, defined=False)
    exponents = {name: int(getattr(base, name) or 0) for name in _EXPONENTS}
    factor = 1.0 if base.factor is None else float(base.factor)
    offset = 0.0 if base.offset is None else float(base.offset)
    if not (math.isfinite(factor) and factor and math.isfinite(offset)):
        raise ValueError(f"unit {u.name} cannot be converted, got factor {factor:g} and offset {offset:g}")
    return Unit(u.name, {k: n for k, n in exponents.items() if n}, factor, offset)
