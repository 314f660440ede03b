"""Units by the names that people and tools write: `mm`, `kN`, `in/s`, `kg.m2/s2`."""

from __future__ import annotations

from fmu_sources.export.units import scale_of

from .units import Unit


def unit(name: str) -> Unit:
    """
    Understand the name of a unit.

    Raises:
        ValueError: If a symbol is not known or the name can be read in two ways.
    """
    scale = scale_of(name)
    return Unit(name, scale.exponents, float(scale.factor), float(scale.offset), exact_factor=scale.factor)
