"""What forbids to call an effect traced, whatever it explains: bounds, limits, thresholds not reached."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from fmu_sources.effects.framework.common import NEVER, SMOOTHING
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.replay.placed_effect import PlacedEffect

from .extended_model import ExtendedModel
from .limits import limit_of
from .study import Study

UNITS = {"{position}": "position", "{position}/s": "velocity", "{value}": "value", "{value}/s": "rate"}
"""Unit of a threshold to the signal that has to reach it."""


def objections(study: Study, model: ExtendedModel, fit: Fit) -> dict[str, str]:
    """The first objection to each effect of a fitted model that there is one to, by the effect."""
    values = dict(model.fixed) | dict(fit.values)
    found = {}
    for placed in model.effects:
        first = next(_against(study, placed, values, fit), None)
        if first is not None:
            found[str(placed)] = first
    return found


def largest_of(study: Study, place: str, role: str) -> float | None:
    """Largest size of a slot's signal along the base; `rate` is that of its value. None where it has none."""
    signals = study.signals[place]
    if role == "rate":
        return float(np.abs(np.diff(signals["value"])).max()) / study.bench.period
    return float(np.abs(signals[role]).max()) if role in signals else None


def _against(study: Study, placed: PlacedEffect, values: Mapping[str, float], fit: Fit) -> Iterator[str]:
    bounds = [placed.short_name(k) for k in fit.at_bound if placed.owns(k)]
    named = ", ".join(name for name in bounds if name != SMOOTHING)
    if named:
        yield f"{named} is at a bound"
    limit = limit_of(study, placed, values)
    if limit is not None:
        yield f"it is at a limit of its law: {limit.because}"
    yield from _unreached(study, placed, values)


def _unreached(study: Study, placed: PlacedEffect, values: Mapping[str, float]) -> Iterator[str]:
    """Thresholds beyond all that was recorded: what acts is the tail of the law, and that is a smooth law."""
    for variable in placed.law.parameters:
        if placed.law.absent.get(variable.name) != NEVER:
            continue
        largest = largest_of(study, placed.place, UNITS.get(variable.unit, ""))
        value = abs(values.get(placed.variable(variable.name), variable.start))
        if largest is not None and value > largest:
            yield f"{variable.name} is beyond what was recorded: {value:.3g} against {largest:.3g} at most"
