"""What forbids to call an effect traced: bounds, limits, thresholds beyond the motion."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from fmu_sources.effects.framework.effect import Rms
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.search.objections import objections

FRICTION = PlacedEffect("contact", "guide_force", "coulomb")
SLACK = PlacedEffect("contact", "rope_force", "slack")
STRIBECK = PlacedEffect("contact", "guide_force", "stribeck")
SINE = np.sin(np.linspace(0.0, 20.0, 500))


def against(placed, values, at_bound=()):
    signals = {"value": 100.0 * SINE, "position": 5e-3 * SINE, "velocity": 0.05 * SINE}
    study = SimpleNamespace(
        signals={placed.place: signals},
        bench=SimpleNamespace(period=1e-3),
        signal_rms=lambda place: Rms(value=70.0, position=3.5e-3, velocity=0.035, load=1.0, duration=10.0),
    )
    model = SimpleNamespace(effects=(placed,), fixed={})
    fit = SimpleNamespace(
        at_bound=tuple(placed.variable(n) for n in at_bound),
        values={placed.variable(k): v for k, v in values.items()},
    )
    return objections(study, model, fit)


def test_a_parameter_at_its_bound_is_told_but_the_rounding_of_a_sign_is_none():
    values = {"level": 4.0, "smoothing": 1e-3}

    assert against(FRICTION, values, ["level"]) == {str(FRICTION): "level is at a bound"}
    assert against(FRICTION, values, ["smoothing"]) == {}


@pytest.mark.parametrize(("limit", "is_reached"), [(3e-3, True), (2e-2, False)])
def test_a_threshold_beyond_the_motion_was_not_seen(limit, is_reached):
    found = against(SLACK, {"limit": limit, "width": 1e-3, "side": 1.0})

    assert (found == {}) is is_reached
    if not is_reached:
        assert found[str(SLACK)] == "limit is beyond what was recorded: 0.02 against 0.005 at most"


def test_a_law_at_its_limit_is_another_law():
    values = {"level": 4.0, "breakaway": 2.0, "stribeck_velocity": 1e-6, "smoothing": 1e-3}

    assert "it is at a limit of its law" in against(STRIBECK, values)[str(STRIBECK)]
