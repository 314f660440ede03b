"""Baseline of the oscillator: fit on the multisines, error on the arrow."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import optimize
from scipy.interpolate import CubicSpline

from fmu_sources.composed.composition import with_effect
from fmu_sources.effects.catalogue import effect
from fmu_sources.rigs import oscillator

RATE = 1e7 / 2**14
ARROW, MULTISINE = (0, 40584), (40800, 127400)
WARM_UP, LENGTH = 300, 600
SUBSTEPS = 2
LINEAR = {"mass": 5.36e-6, "damping": 2.24e-4, "stiffness": 0.987}
CUBIC = "restoring_force_cubic_stiffness_coefficient"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def record(data):
    found = np.load(data / "silverbox" / "snls80mV.npz")
    return tuple(found[name].astype(float) - found[name].mean(dtype=float) for name in ("u_V", "y_V"))


@pytest.fixture(scope="module")
def error(record, states_of):
    """Simulated minus measured output [V] on a stretch, windows with a warm-up of their own."""
    u, y = record
    spline = CubicSpline(np.arange(len(u)), u)

    def compute(model, values, stretch):
        begins = np.arange(stretch[0], stretch[1], LENGTH)
        n = (WARM_UP + LENGTH) * SUBSTEPS
        places = np.arange(n)[:, None, None] + np.array([0.0, 0.5, 1.0])[None, :, None]
        times = places / SUBSTEPS + (begins - WARM_UP)[None, None, :]
        driven = np.where((times >= 0) & (times <= len(u) - 1), spline(np.clip(times, 0, len(u) - 1)), 0.0)
        found = states_of(model, values, driven, 1.0 / (SUBSTEPS * RATE))[WARM_UP * SUBSTEPS :: SUBSTEPS]
        indices = np.arange(LENGTH)[:, None] + begins[None, :]
        inside = indices < stretch[1]
        return (found - y[np.minimum(indices, len(y) - 1)])[inside]

    return compute


def fitted(error, model, start):
    scale = np.array(list(start.values()))

    def residual(theta):
        return 1e3 * error(model, dict(zip(start, theta * scale, strict=True)), MULTISINE)

    found = optimize.least_squares(residual, np.ones(len(scale)), xtol=1e-6, ftol=1e-6)
    return dict(zip(start, found.x * scale, strict=True))


def rms(values):
    return 1e3 * np.sqrt(np.mean(values**2))


def test_linear_oscillator_leaves_14_millivolts_on_the_arrow(error):
    values = fitted(error, oscillator.MODEL, LINEAR)

    assert rms(error(oscillator.MODEL, values, MULTISINE)) == pytest.approx(6.76, abs=0.05)
    assert rms(error(oscillator.MODEL, values, ARROW)) == pytest.approx(14.34, abs=0.05)


@pytest.mark.long
def test_cubic_stiffness_leaves_half_a_millivolt(error):
    model = with_effect(oscillator.MODEL, "restoring_force", effect("cubic_stiffness"))
    values = fitted(error, model, {**LINEAR, CUBIC: 3.9})

    assert rms(error(model, values, MULTISINE)) == pytest.approx(0.328, abs=0.005)
    assert rms(error(model, values, ARROW)) == pytest.approx(0.462, abs=0.005)
    assert values[CUBIC] / values["mass"] == pytest.approx(7.29e5, rel=0.02)
