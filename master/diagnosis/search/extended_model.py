"""The base of a part with effects: what is fixed and what is fitted of each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from master.diagnosis.numerics.least_squares import FreeParameter
from master.diagnosis.replay.placed_effect import PlacedEffect


@dataclass(frozen=True)
class ExtendedModel:
    """
    Effects in the order in which they were added; no effect is the base itself.

    `fixed` are values that a fit leaves alone, by `fmu.variable`, `parameters` those that it changes, both of
    the effects only.
    """

    effects: tuple[PlacedEffect, ...] = ()
    fixed: Mapping[str, float] = field(default_factory=dict)
    parameters: tuple[FreeParameter, ...] = ()

    @property
    def name(self) -> str:
        """The last effect, as `fmu.slot: effect`."""
        return str(self.effects[-1]) if self.effects else "base"

    def started_at(self, values: Mapping[str, float]) -> ExtendedModel:
        """Return the same with other first guesses."""
        moved = tuple(replace(p, start=values.get(p.name, p.start)) for p in self.parameters)
        return replace(self, parameters=moved)

    def without(self, placed: PlacedEffect) -> ExtendedModel:
        """Return the model without one of its effects."""
        return ExtendedModel(
            tuple(e for e in self.effects if e != placed),
            {k: v for k, v in self.fixed.items() if not placed.owns(k)},
            tuple(p for p in self.parameters if not placed.owns(p.name)),
        )

    def with_effect(
        self, placed: PlacedEffect, fixed: Mapping[str, float], parameters: tuple[FreeParameter, ...]
    ) -> ExtendedModel:
        """Return the model with one effect more."""
        return ExtendedModel(
            (*self.effects, placed), dict(self.fixed) | dict(fixed), (*self.parameters, *parameters)
        )
