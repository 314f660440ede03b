"""An effect in a slot of an FMU, and what a fit may change of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from fmu_sources.composed.composition import AND, SEPARATOR
from fmu_sources.effects import catalogue
from fmu_sources.effects.framework.effect import Effect, Rms
from master.diagnosis.numerics.least_squares import FreeParameter

LARGEST = 1e4  # of its typical size


@dataclass(frozen=True, order=True)
class PlacedEffect:
    """An effect in a slot of an FMU."""

    fmu: str
    slot: str
    effect: str

    @property
    def place(self) -> str:
        """Its slot, as `fmu.slot`."""
        return f"{self.fmu}.{self.slot}"

    @property
    def prefix(self) -> str:
        """Start of the names of its parameters in the FMU, without the separating underscore."""
        return f"{self.slot}_{self.effect}"

    @property
    def law(self) -> Effect:
        """The effect itself."""
        return catalogue.effect(self.effect)

    def variable(self, name: str) -> str:
        """Name one of its parameters or states, as `fmu.variable`."""
        return f"{self.fmu}.{self.prefix}_{name}"

    def owns(self, variable: str) -> bool:
        """Whether a variable `fmu.variable` is one of its own."""
        return variable.startswith(self.variable(""))

    def short_name(self, variable: str) -> str:
        """Name by which the effect knows one of its variables."""
        return variable.removeprefix(self.variable(""))

    def __str__(self) -> str:
        return f"{self.place}: {self.effect}"


def source_with(source: str, effects: Iterable[PlacedEffect]) -> str:
    """Name of a model with effects in its slots."""
    for placed in effects:
        source += (AND if SEPARATOR in source else SEPARATOR) + placed.prefix
    return source


def free_parameters(placed: PlacedEffect, rms: Rms) -> tuple[FreeParameter, ...]:
    """What a fit changes of an effect in a slot whose signals have these sizes; names as `fmu.variable`."""
    scale = placed.law.scale(rms)
    parameters = []
    for v in placed.law.parameters:
        if v.name not in placed.law.fitted:
            continue
        size = scale.get(v.name, 1.0) or 1.0
        low = v.minimum if v.minimum is not None else -float("inf")
        if v.above is not None:
            low = max(v.above, placed.law.smallest_share(v.name) * size)
        high = v.maximum if v.maximum is not None else LARGEST * size
        parameters.append(FreeParameter(placed.variable(v.name), size, low, high, abs(size)))
    return tuple(parameters)


def fixed_values(placed: PlacedEffect, rms: Rms, variant: Mapping[str, float]) -> dict[str, float]:
    """What a fit leaves alone of an effect; names as `fmu.variable`."""
    scale = placed.law.scale(rms)
    held = {name: scale[name] for name in placed.law.held if name in scale}
    return {placed.variable(name): float(value) for name, value in (held | dict(variant)).items()}
