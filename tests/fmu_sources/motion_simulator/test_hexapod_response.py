from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.fmu_sources.motion_simulator.hexapod import NEUTRAL, N, at_rest, linearise, phase, read, response

OFFSET_POSE = (0.15, 0.1, 0.1, 0.1, 0.0, 0.0)
SINE, AMPLITUDE = 2.6, 0.01  # Hz, m
SAMPLE, DEAD_TIME = 1e-3, 2e-3


@pytest.fixture(scope="module")
def neutral():
    return linearise()


@pytest.mark.parametrize(
    ("frequency", "expected"), [(0.43, -5.14), (0.87, -10.31), (0.97, -11.46), (2.6, -28.83)]
)
def test_vertical_phase_is_as_published(neutral, frequency, expected):
    assert phase(response(neutral, frequency)) == pytest.approx(expected, abs=0.3)


@pytest.mark.parametrize(
    ("frequency", "expected"), [(0.43, 0.997), (0.87, 0.987), (0.97, 0.984), (2.6, 0.912)]
)
def test_vertical_magnitude_is_as_published(neutral, frequency, expected):
    assert abs(response(neutral, frequency)) == pytest.approx(expected, abs=0.005)


def test_bandwidth_is_as_published(neutral):
    minus_3_dB = brentq(lambda f: abs(response(neutral, f)) - math.sqrt(0.5), 3.0, 10.0)
    minus_90_deg = brentq(lambda f: phase(response(neutral, f)) + 90.0, 5.0, 15.0)

    assert minus_3_dB == pytest.approx(6.28, abs=0.1)
    assert minus_90_deg == pytest.approx(11.0, abs=0.1)


def test_vertical_poles_are_as_published(neutral):
    poles = np.linalg.eigvals(neutral[0])

    for expected in (-18.9, -59.4, -90.9, -1944.0):
        assert np.abs(poles / expected - 1).min() < 2e-3
    assert poles.real.max() < 0


def test_compliance_to_the_contact_force_is_as_published(neutral):
    A, _ = neutral
    nu = linear_acceleration_of_a_force(at_rest())
    compliance = [abs(np.linalg.solve(2j * math.pi * f * np.eye(N) - A, nu)[2]) for f in (0.97, 2.6)]

    assert 300 * compliance[0] == pytest.approx(9.3e-6, rel=0.02)
    assert 2700 * compliance[1] == pytest.approx(170e-6, rel=0.02)


def linear_acceleration_of_a_force(instance):
    model = instance.model
    x = model.states.record([instance[name] for name in model.states.names])
    p = model.parameters.record([instance[name] for name in model.parameters.names])
    changes = []
    for force in (0.0, 1.0):
        u = model.inputs.record([force if name == "f_contact" else 0.0 for name in model.inputs.names])
        changes.append(np.array(model.continuous.flat(model.derivatives(0.0, x, u, p, instance.m))))
    return (changes[1] - changes[0])[:N]


@pytest.mark.parametrize("pose", [NEUTRAL, OFFSET_POSE], ids=["neutral", "offset"])
def test_a_sine_of_the_whole_model_follows_the_linearisation(pose):
    measured = sine_response(pose)
    expected = response(linearise(pose), SINE)
    # each command waits for its dead time and is held: half a sampling period on average
    delay = 360 * SINE * (DEAD_TIME + SAMPLE / 2)

    assert abs(measured[2]) == pytest.approx(abs(expected), abs=0.002)
    assert phase(measured[2]) == pytest.approx(phase(expected) - delay, abs=0.2)


def test_the_offset_pose_answers_as_published():
    measured = sine_response(OFFSET_POSE)

    assert abs(measured[2]) == pytest.approx(0.9133, abs=0.002)
    # published with the hold of the command, without its dead time
    assert phase(measured[2]) + 360 * SINE * DEAD_TIME == pytest.approx(-29.31, abs=0.2)
    assert np.abs(measured[[0, 1]]).max() == pytest.approx(0.0085, abs=0.0015)


def sine_response(pose, n=1600):
    """Pose per amplitude of a sine of s_cmd, fitted from 0.8 s on, shape (6,)."""
    instance = at_rest(pose)
    w, poses = 2 * math.pi * SINE, []
    for k in range(n):
        instance["s_cmd"] = AMPLITUDE * math.sin(w * k * SAMPLE)
        instance.step(k * SAMPLE, SAMPLE)
        poses.append(read(instance, "pose"))
    t = SAMPLE * np.arange(1, n + 1)
    regressors = np.column_stack(
        [np.sin(w * t), np.cos(w * t), np.ones(n), np.sin(2 * w * t), np.cos(2 * w * t)]
    )
    settled = t > 0.8
    sine, cosine, *_ = np.linalg.lstsq(regressors[settled], np.array(poses)[settled], rcond=None)[0]
    return (sine + 1j * cosine) / AMPLITUDE
