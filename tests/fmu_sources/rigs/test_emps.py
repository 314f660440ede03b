"""
Baseline of the servo axis, by the authors' processing.

Position: Butterworth low-pass of order 4 at 100 Hz without phase, central differences; 20 samples cut off at
both ends; force and regressors decimated by 10 without phase; errors relative to the norm of the force.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import io, optimize, signal

from fmu_sources.composed.composition import with_effect
from fmu_sources.effects.catalogue import effect
from fmu_sources.framework.instance import Instance
from fmu_sources.rigs import servo_axis, servo_axis_inverse

CUT, EVERY = 20, 10
AUTHORS = {"mass": 95.109, "damping": 203.50, "coulomb": 20.394, "offset": -3.165}
SMOOTHING = {"smoothing": 1e-4}


@pytest.fixture(scope="module")
def records(data):
    return [processed(load(data, name)) for name in ("DATA_EMPS", "DATA_EMPS_PULSES")]


def load(data, name):
    found = io.loadmat(data / "emps" / f"{name}.mat")
    return {key: np.squeeze(value) for key, value in found.items() if not key.startswith("__")}


def processed(record):
    q = signal.filtfilt(*signal.butter(4, 100.0, fs=1000.0), record["qm"])
    der_q = np.gradient(q, 1e-3)
    inputs = {"q": q, "der_q": der_q, "der_der_q": np.gradient(der_q, 1e-3)}
    return {k: v[CUT:-CUT] for k, v in inputs.items()}, thinned((record["vir"] * record["gtau"])[CUT:-CUT])


def thinned(values):
    return signal.decimate(values, EVERY, ftype="iir", zero_phase=True)


def fitted(outputs_of, model, start, record):
    inputs, force = record

    def residual(theta):
        values = dict(zip(start, theta, strict=True))
        return thinned(outputs_of(model, values, **inputs).force) - force

    found = optimize.least_squares(residual, list(start.values()), x_scale=np.abs(list(start.values())) + 1.0)
    return dict(zip(start, found.x, strict=True))


def error(outputs_of, model, values, record):
    inputs, force = record
    left = thinned(outputs_of(model, values, **inputs).force) - force
    return 100.0 * np.linalg.norm(left) / np.linalg.norm(force)


def with_laws(*names):
    model = servo_axis_inverse.MODEL
    for name in names:
        model = with_effect(
            model, "friction", effect(name), prefix=name, starts={} if name == "offset" else SMOOTHING
        )
    return model


@pytest.mark.parametrize(
    ("laws", "start", "identification", "validation"),
    [
        ((), {}, 17.95, 17.79),
        (("offset",), {"offset_offset": 0.0}, 17.00, 16.92),
        (("coulomb", "offset"), {"coulomb_level": 10.0, "offset_offset": 0.0}, 4.04, 5.95),
    ],
)
def test_errors_are_those_computed_independently(
    outputs_of, records, laws, start, identification, validation
):
    model = with_laws(*laws)
    values = fitted(outputs_of, model, {"mass": 90.0, "damping": 200.0, **start}, records[0])

    errors = [error(outputs_of, model, values, record) for record in records]
    assert errors == pytest.approx([identification, validation], abs=0.03)


def test_parameters_are_the_authors_within_one_percent(outputs_of, records):
    start = {"mass": 90.0, "damping": 200.0, "coulomb_level": 10.0, "offset_offset": 0.0}
    values = fitted(outputs_of, with_laws("coulomb", "offset"), start, records[0])

    assert list(values.values()) == pytest.approx(list(AUTHORS.values()), rel=0.01)


def test_asymmetry_gains_little_more(outputs_of, records):
    start = {"mass": 90.0, "damping": 200.0, "asymmetric_friction_forward": 10.0}
    start |= {"asymmetric_friction_backward": 10.0, "asymmetric_friction_damping_difference": 1.0}
    model = with_laws("asymmetric_friction", "offset")
    values = fitted(outputs_of, model, start, records[0])

    errors = [error(outputs_of, model, values, record) for record in records]
    assert errors[0] < 3.95
    assert errors[1] < 5.8


def test_cascade_gives_the_recorded_voltage(data):
    record = load(data, "DATA_EMPS_PULSES")
    axis = Instance(servo_axis.MODEL)
    axis.initialise()
    found = []
    for k in range(2, 3000):
        axis["q"], axis["last_q"], axis["second_last_q"] = record["qm"][[k, k - 1, k - 2]]
        axis["q_ref"], axis["pulse"] = record["qg"][k], 1.0138 * record["pulses_N"][k]
        axis.step(k * 1e-3, 1e-3)
        found.append(axis["v"])

    assert np.std(found - record["vir"][2:3000]) < 6e-3


@pytest.mark.long
def test_closed_loop_follows_the_recorded_position(data):
    record = load(data, "DATA_EMPS")
    model = with_effect(servo_axis.MODEL, "friction", effect("coulomb"), starts={"level": 20.4})
    model = with_effect(model, "friction", effect("offset"), starts={"offset": -3.17})
    errors = {}
    for name, axis in (("viscous", Instance(servo_axis.MODEL)), ("with effects", Instance(model))):
        axis.initialise()
        found = []
        for k in range(len(record["qg"])):
            found.append(axis["v"])
            axis["q_ref"] = record["qg"][k]
            axis.step(k * 1e-3, 1e-3)
        errors[name] = np.linalg.norm(found[1:] - record["vir"][:-1]) / np.linalg.norm(record["vir"])

    assert errors["with effects"] < 0.06 < 0.17 < errors["viscous"]
