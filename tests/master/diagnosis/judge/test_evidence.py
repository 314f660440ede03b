"""Evidence on constructed residuals: which output, which rows, a parameter that changes."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from master.diagnosis.judge.evidence import drifts, features_of, shapes_of, worst_output
from master.diagnosis.numerics.least_squares import Fit, FreeParameter
from master.diagnosis.numerics.whiteness import variance_inflation
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.study import Study

N = 1600
T = np.arange(N) * 1e-3
X = np.sin(40.0 * T)


def test_shapes_of_a_signal_by_hand():
    shapes = shapes_of(np.array([-2.0, 0.0, 3.0]))

    assert {name: v.tolist() for name, v in shapes.items()} == {
        "abs": [2.0, 0.0, 3.0],
        "squared": [4.0, 0.0, 9.0],
        "cubed": [-8.0, 0.0, 27.0],
        "sign": [-1.0, 0.0, 1.0],
    }


def test_worst_output_leaves_most_of_its_motion(study_of):
    measured = np.column_stack([100.0 * X, X])

    assert worst_output(study_of(measured, [], output_scale=np.array([10.0, 0.5]))) == 1


def test_features_are_the_signals_that_move_each_once(study_of):
    signals = {
        "a.force": {"value": np.full(N, 3.0), "position": X, "velocity": np.cos(40.0 * T)},
        "b.u": {"value": 2.0 * X + 1.0},  # the position again
    }
    bench = SimpleNamespace(measured=X[:, None], name="a", compared_rows=lambda values: values[:100])
    study = study_of(X[:, None], [], bench=bench)
    study.__dict__["signals"] = signals

    found = features_of(study)

    assert list(found) == ["a.force position", "a.force velocity"]
    assert np.array_equal(found["a.force position"], X[:100])


def test_a_stiffness_that_grows_with_time_drifts_by_its_slope(study_of, monkeypatch):
    """Y = (2 + t) x: fitted in eight groups, k is 2 + their mean time, its slope 1 per second."""

    def simulate(self, effects, values, everything=False):
        return (values["a.k"] * X)[:, None]

    monkeypatch.setattr(Study, "simulate", simulate)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(N)
    measured = ((2.0 + T) * X + noise)[:, None]
    bench = SimpleNamespace(measured=measured, name="a", row_period=1e-3)
    study = study_of(measured, [], bench=bench, base=(FreeParameter("a.k", 2.8, scale=1.0),))
    base = Fit("base", {"a.k": 2.8}, {}, (2.8 * X)[:, None], 0.0)

    [found] = drifts(study, ExtendedModel(), base)

    assert found.parameter == "a.k"
    assert not found.is_constant
    assert found.along == "time"
    assert found.slope == pytest.approx(1.0, abs=0.05)
    assert found.values == pytest.approx(2.0 + T.reshape(8, -1).mean(axis=1), abs=0.03)


def test_variance_of_a_coloured_mean_is_that_of_its_autocorrelation():
    """First-order autoregression with a = 0.8: (1 + a)/(1 - a) = 9."""
    rng = np.random.default_rng(2)
    e = np.zeros(200_000)
    for k in range(1, len(e)):
        e[k] = 0.8 * e[k - 1] + rng.standard_normal()

    assert variance_inflation(e) == pytest.approx(9.0, rel=0.1)
    assert variance_inflation(rng.standard_normal(10_000)) == 1.0
