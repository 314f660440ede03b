"""A pendulum that swings far: it is linear around its motion, but not in the same way at all times."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from master.diagnosis.answer.answer import answer

INERTIA = 0.11
DAMPING = 0.01
GRAVITY_TORQUE = 2.2
DRAG = 0.012  # N m s2/rad2
NOISE = 2e-4  # rad
BETWEEN_ROWS = 1e-3  # lines between rows of the torque lack (omega h)^2 / 12 of a wave, 2e-4 of the fastest

CASE = """
name: swing
recordings: {swing: swing.npz}
time: {column: t, unit: s}
fmus: {rig: {source: pendulum}}
signals: {q: {column: q, unit: rad}, torque: {column: torque, unit: N m}}
inputs: {rig.torque: torque}
compared: {rig.q: q}
refit:
  rig.inertia: {low: 0.001, high: 10}
  rig.damping: {low: 0, high: 10}
  rig.gravity_torque: {low: 0.01, high: 100}
starts: {rig.q: [-1, 1], rig.der_q: [-5, 5]}
split:
  blocks: [fit, select, fit, sealed, fit, select, fit, select, fit, sealed, fit, select, fit, sealed]
  guard: 0.2
"""


def torque(t):
    return (
        0.6 * np.sin(0.8 * np.pi * t)
        + 0.5 * np.sin(1.8 * np.pi * t + 1.0)
        + 0.3 * np.sin(3.2 * np.pi * t + 2.0)
    )


def recorded(path):
    """Thirty seconds by another integrator, with noise: up to 60 degrees to either side."""

    def rates(t, x):
        drag = DAMPING * x[1] + DRAG * x[1] * abs(x[1])
        return [x[1], (torque(t) - GRAVITY_TORQUE * np.sin(x[0]) - drag) / INERTIA]

    t = np.arange(6000) * 0.005
    swing = solve_ivp(rates, (0.0, 30.0), [0.0, 0.0], t_eval=t, rtol=1e-8, atol=1e-10, max_step=0.005)
    q = swing.y[0] + np.random.default_rng(7).normal(0.0, NOISE, len(t))
    np.savez(path, t=t, torque=torque(t), q=q)
    return q


@pytest.mark.long
def test_drag_is_traced_although_the_response_to_it_changes_with_the_angle(tmp_path):
    """A convolution with one step's answer promises next to nothing of the drag, and much of other laws."""
    q = recorded(tmp_path / "swing.npz")
    assert np.abs(q).max() > 0.8
    (tmp_path / "case.yaml").write_text(CASE, encoding="utf-8")

    report = answer(tmp_path / "case.yaml", tmp_path / "out", lambda _: None)

    assert report["verdict"] == "traced"
    assert [e["effect"] for e in report["effects"]] == ["quadratic_damping"]
    found = report["parameters"]
    truth = {"inertia": INERTIA, "damping": DAMPING, "gravity_torque": GRAVITY_TORQUE}
    for name, value in truth.items():
        assert found[f"rig.{name}"]["with_effect"] == pytest.approx(value, rel=BETWEEN_ROWS, abs=1e-5)
    assert report["after"]["rig.q"]["rmse"] < 1.1 * NOISE
