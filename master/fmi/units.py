"""Units: whether two are the same quantity, how a value goes from one to the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction


@dataclass(frozen=True)
class Unit:
    """
    A unit as FMI defines it: value in SI = factor * value + offset, with SI exponents.

    `defined` is false where an FMU names the unit and does not say what it is. `exact_factor` is that of a
    unit that is understood by its name; without it, factor and offset are the decimal numbers that they are
    written as.
    """

    name: str
    exponents: Mapping[str, int] = field(default_factory=dict)
    factor: float = 1.0
    offset: float = 0.0
    defined: bool = True
    exact_factor: Fraction | None = None

    @property
    def is_known(self) -> bool:
        """Whether it can be converted: it is defined, or understood by its name."""
        return self.defined or self.exact_factor is not None

    @property
    def _factor(self) -> Fraction:
        return Fraction(repr(self.factor)) if self.exact_factor is None else self.exact_factor

    @property
    def _offset(self) -> Fraction:
        return Fraction(repr(self.offset))


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
        return self.is_affine and not self.is_scaled

    @property
    def is_affine(self) -> bool:
        """Whether there is no table."""
        return not self.table

    @property
    def is_scaled(self) -> bool:
        """Whether factor or offset change anything."""
        return (self.factor, self.offset) != (1.0, 0.0)

    def of(self, value: float) -> float:
        """Convert one value."""
        mapped = dict(self.table).get(value, value)
        return self.factor * mapped + self.offset if self.is_scaled else mapped

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

    A missing unit fits every unit. A unit that its FMU names without defining it fits the same name, and is
    otherwise what its name says; one whose name says nothing fits the same name only.
    """
    if source is None or target is None:
        return Conversion()
    if source.name == target.name and not (source.defined and target.defined):
        return Conversion()
    if not (source.is_known and target.is_known):
        return None
    if source.exponents != target.exponents:
        return None
    if (source.factor, source.offset) == (target.factor, target.offset):
        return Conversion()
    factor = source._factor / target._factor
    offset = (source._offset - target._offset) / target._factor
    return Conversion(float(factor), float(offset))
