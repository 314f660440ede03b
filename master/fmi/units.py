"""Whether two units are the same quantity, and how a value goes from one to the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


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
    """Value at the target = factor * value at the source + offset."""

    factor: float = 1.0
    offset: float = 0.0

    @property
    def is_identity(self) -> bool:
        """Whether nothing changes."""
        return self.factor == 1.0 and self.offset == 0.0


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
