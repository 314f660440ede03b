"""What forbids to call an effect traced, whatever it explains: bounds, limits, thresholds not reached."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from fmu_sources.effects.framework.common import NEVER, SMOOTHING
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.search.limits import limit_of

from .part_result import PartResult

UNITS = {"{position}": "position", "{position}/s": "velocity", "{value}": "value", "{value}/s": "rate"}
"""Unit of a threshold to the signal that has to reach it."""


def objections(result: PartResult) -> dict[str, str]:
    """The first objection to each chosen effect that there is one to, by the effect."""
    found = {}
    for placed in result.chosen.effects:
        first = next(_against(result, placed), None)
        if first is not None:
            found[str(placed)] = first
    return found


def _against(result: PartResult, placed: PlacedEffect) -> Iterator[str]:
    values = result.values
    bounds = [placed.short_name(k) for k in result.fit.at_bound if placed.owns(k)]
    named = ", ".join(name for name in bounds if name != SMOOTHING)
    if named:
        yield f"{named} is at a bound"
    limit = limit_of(result.study, placed, values)
    if limit is not None:
        yield f"it is at a limit of its law: {limit.because}"
    yield from _unreached(result, placed, values)


def _unreached(result: PartResult, placed: PlacedEffect, values: Mapping[str, float]) -> Iterator[str]:
    """Thresholds beyond all that was recorded: what acts is the tail of the law, and that is a smooth law."""
    signals = result.study.signals[placed.place]
    for variable in placed.law.parameters:
        if placed.law.absent.get(variable.name) != NEVER:
            continue
        role = UNITS.get(variable.unit, "")
        value = abs(values.get(placed.variable(variable.name), variable.start))
        if role == "rate":
            largest = float(np.abs(np.diff(signals["value"])).max()) / result.study.bench.period
        elif role in signals:
            largest = float(np.abs(signals[role]).max())
        else:
            continue
        if value > largest:
            yield f"{variable.name} is beyond what was recorded: {value:.3g} against {largest:.3g} at most"
