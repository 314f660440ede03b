"""What is in the slots along a replay, at the time of each row."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from fmu_sources.composed import registry
from master.diagnosis.case.cut import MeasuredInput
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
            fmus=(fmu,), inputs={fmu: {name: MeasuredInput(name, "end") for name in inputs}}, wired={fmu: {}}
        )
        self._inputs = {name: np.broadcast_to(np.asarray(v, dtype=float), n) for name, v in inputs.items()}
        self._states = {f"{fmu}.{k}": np.broadcast_to(v, n) for k, v in states.items()}

    @property
    def times(self):
        return np.concatenate([np.arange(n) * PERIOD for n in ROWS.values()])

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
