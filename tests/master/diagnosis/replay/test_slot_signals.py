"""What is in the slots along a replay, at the time of each row."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from fmu_sources.composed import registry
from fmu_sources.framework.instance import Instance
from master.diagnosis.case.cut import MeasuredInput
from master.diagnosis.replay.own_values import of_recording
from master.diagnosis.replay.replay_bench import Segment
from master.diagnosis.replay.slot_signals import slot_signals

PERIOD = 1e-3
ROWS = {"first": 1000, "second": 250}


class ReplayBench:
    """Two recordings of one FMU whose inputs were all measured."""

    period = PERIOD
    segments = (Segment("first", 0, 600), Segment("first", 600, 1000), Segment("second", 0, 250))

    def __init__(self, fmu, inputs, states):
        n = sum(ROWS.values())
        self.part = SimpleNamespace(
            fmus=(fmu,),
            inputs={fmu: {name: MeasuredInput(name, "end") for name in inputs}},
            wired={fmu: {}},
            conversions={},
        )
        self._inputs = {name: np.broadcast_to(np.asarray(v, dtype=float), n) for name, v in inputs.items()}
        self._states = {f"{fmu}.{k}": np.broadcast_to(v, n) for k, v in states.items()}

    @property
    def times(self):
        return np.concatenate([np.arange(n) * PERIOD for n in ROWS.values()])

    @property
    def recordings(self):
        return {name: range(n) for name, n in ROWS.items()}

    def values_in(self, values, recording):
        return of_recording(values, recording, {})

    def first_sample(self, recording):
        return {"first": 0, "second": ROWS["first"]}[recording]

    def signal(self, name):
        return self._inputs[name]

    def record(self, player, values):
        return self._states


def signals(fmu, parameters, inputs, states):
    system = SimpleNamespace(model=registry.load)
    return slot_signals(system, ReplayBench(fmu, inputs, states), None, {fmu: parameters})


def test_a_stiffness_that_varies_is_taken_at_the_time_of_each_row():
    """k_p = 400e3 + 80e3 sin(2 pi t) N/m, stretched by 10 mm; each recording begins at 0 s."""
    inputs = dict.fromkeys(registry.load("docking_contact").inputs.names, 0.0) | {"s_act": 0.01}
    states = dict.fromkeys(registry.load("docking_contact").continuous.names, 0.0)
    parameters = {"k_p": 400e3, "k_p_amplitude": 80e3, "k_p_frequency": 1.0}

    force = signals("docking_contact", parameters, inputs, states)["docking_contact.rope_force"]["value"]

    t = np.concatenate([np.arange(n) * PERIOD for n in ROWS.values()])
    assert force == pytest.approx(4000.0 + 800.0 * np.sin(2.0 * np.pi * t), rel=1e-12)
    assert (force.min(), force.max()) == pytest.approx((3200.0, 4800.0))


def test_a_sampled_model_starts_again_with_each_segment():
    """A sensor without lag gives what it is fed; with noise each segment begins with the same number."""
    f_act = np.arange(float(sum(ROWS.values())))

    found = signals("force_sensor", {"T_f": 0.0, "sigma": 1.0, "sample_time": PERIOD}, {"f_act": f_act}, {})

    noise = found["force_sensor.output"]["value"] - f_act
    assert noise[600:850] == pytest.approx(noise[:250], abs=1e-9)
    assert noise[1000:] == pytest.approx(noise[:250], abs=1e-9)
    assert noise[:400].std() == pytest.approx(1.0, abs=0.15)


def test_a_sampled_model_in_its_slots_is_what_its_instance_gives_step_by_step():
    """The sensor with lag and noise, stepped by the class that both FMU flavours behave like."""
    f_act = 20.0 * np.sin(0.01 * np.arange(float(sum(ROWS.values()))))
    parameters = {"T_f": 0.02, "sigma": 1.0, "sample_time": PERIOD}
    sensor = Instance(registry.load("force_sensor"))
    for name, value in parameters.items():
        sensor[name] = value
    expected = []
    for k in range(600):
        sensor["f_act"] = f_act[k]
        if k:
            sensor.step((k - 1) * PERIOD, PERIOD)
        else:
            sensor.initialise(0.0)
        expected.append(sensor["f_mea"])

    found = signals("force_sensor", parameters, {"f_act": f_act}, {})

    assert found["force_sensor.output"]["value"][:600].tolist() == expected


def test_a_model_that_samples_faster_than_the_rows_takes_all_its_samples():
    """Two samples a row with a lag: q = exp(-T/T_f) twice, and both see the force of the row."""
    f_act = np.where(np.arange(sum(ROWS.values())) < 1, 0.0, 1.0)
    parameters = {"T_f": 0.01, "sigma": 0.0, "sample_time": 0.5 * PERIOD}

    value = signals("force_sensor", parameters, {"f_act": f_act}, {})["force_sensor.output"]["value"]

    q = np.exp(-0.05)
    held = (1.0 - q) / 0.05  # share of the new force of a sample that it rises in
    first = 1.0 - held
    assert value[1] == pytest.approx(q * first + 1.0 - q, rel=1e-12)


def test_a_parameter_that_each_recording_has_for_itself_is_that_of_each_row():
    inputs = dict.fromkeys(registry.load("servo_axis_inverse").inputs.names, 0.0) | {"der_q": 2.0}
    parameters = {"damping": 1.0, "damping@first": 10.0, "damping@second": 30.0}
    value = signals("servo_axis_inverse", parameters, inputs, {})["servo_axis_inverse.friction"]["value"]

    assert np.unique(value[: ROWS["first"]]).tolist() == [20.0]
    assert np.unique(value[ROWS["first"] :]).tolist() == [60.0]
