"""With which values an FMU is linear and constant in time, and when it learns: what it declares of itself."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree as ET


@dataclass(frozen=True)
class DeclaredLinear:
    """
    A value with which the FMU is linear and constant; see `fmu_sources.framework.model.Linear`.

    `frequency` names the parameter [Hz] by which the FMU otherwise repeats itself; None if it does not vary.
    """

    parameter: str
    value: str
    reason: str
    frequency: str | None = None


@dataclass(frozen=True)
class DeclaredLearning:
    """A choice with which the FMU learns until it is held; see `fmu_sources.framework.model.Learning`."""

    by: str
    item: str
    held_by: str


def declared_linear(root: ET.Element) -> tuple[DeclaredLinear, ...]:
    """Read the `Linear` elements of a model description."""
    return tuple(
        DeclaredLinear(
            parameter=e.get("parameter", ""),
            value=e.get("value", ""),
            reason=e.get("reason", ""),
            frequency=e.get("frequency"),
        )
        for e in root.iterfind(".//Coupling/Linear")
    )


def declared_learning(root: ET.Element) -> tuple[DeclaredLearning, ...]:
    """Read the `Learning` elements of a model description."""
    return tuple(
        DeclaredLearning(e.get("by", ""), e.get("item", ""), e.get("held", ""))
        for e in root.iterfind(".//Coupling/Learning")
    )
