"""
Parameters of a fitted model that have no number: the recording says next to nothing of them.

What an effect does may be sure where one of its numbers is not: all that lies in a 95 % interval fits as
well, and where that is nearly everything that the parameter could be, the number in its middle is made up.
"""

from __future__ import annotations

from collections.abc import Mapping

from fmu_sources.effects.catalogue import listed
from fmu_sources.effects.framework.common import SMOOTHING
from master.diagnosis.numerics.deviations import NORMAL
from master.diagnosis.numerics.least_squares import Fit, FreeParameter
from master.diagnosis.replay.placed_effect import LARGEST, PlacedEffect

from .extended_model import ExtendedModel
from .objections import largest_of
from .study import Study

NEARLY_ALL = 0.9  # of what a parameter could be
POSITION = "{position}"


def unknown_numbers(study: Study, model: ExtendedModel, fit: Fit) -> dict[str, str]:
    """Why a parameter has no number, by `fmu.variable`, of those of base and effects that have none."""
    found = {}
    for p in (*study.base, *model.parameters):
        if p.name not in fit.deviations:
            continue
        half = NORMAL * fit.deviations[p.name]
        value = fit.values[p.name]
        owner = next((e for e in model.effects if e.owns(p.name)), None)
        if owner is not None and owner.effect not in listed():
            continue  # a coefficient of a learned law, which is drawn with its band
        recorded = None if owner is None else _recorded(study, owner, p)
        if not half < float("inf"):
            found[p.name] = "nothing recorded depends on it"
        elif _is_everything(p, value, half, recorded) or (owner and _is_of_any_size(p, value, half)):
            found[p.name] = (
                f"its 95 % interval of +- {half:.2g} around {value:.3g} holds nearly all that it could be"
            )
    return found


def of_effect(placed: PlacedEffect, unknown: Mapping[str, str]) -> dict[str, str]:
    """Those of one effect by their short names; how a sign is rounded is no number that anybody asks for."""
    own = {placed.short_name(k): why for k, why in unknown.items() if placed.owns(k)}
    own.pop(SMOOTHING, None)
    return own


def _is_of_any_size(p: FreeParameter, value: float, half: float) -> bool:
    """Whether a number that need not be small for its kind may be nothing, or twice as much."""
    return half > max(abs(value), p.scale)


def _is_everything(p: FreeParameter, value: float, half: float, recorded: float | None) -> bool:
    """Whether an interval holds nearly all between bounds that mean something, or of what was recorded."""
    ranges = [(p.low, p.high)] if p.high - p.low < LARGEST * p.scale else []
    if recorded is not None:
        ranges.append((max(p.low, -recorded), recorded))
    return any(
        min(value + half, high) - max(value - half, low) >= NEARLY_ALL * (high - low) > 0.0
        for low, high in ranges
    )


def _recorded(study: Study, owner: PlacedEffect, p: FreeParameter) -> float | None:
    """Largest position that was recorded, for a parameter that is one."""
    unit = next(v.unit for v in owner.law.parameters if v.name == owner.short_name(p.name))
    return largest_of(study, owner.place, "position") if unit == POSITION else None
