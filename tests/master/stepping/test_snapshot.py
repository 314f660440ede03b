"""A run that goes on from the bytes of a snapshot has the bits of one that was never stopped."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from master.errors import ConfigError, DataError
from master.experiment.prepare import Request, prepare
from master.stepping.outcome import RunOptions
from master.stepping.simulate import simulate
from master.stepping.snapshot import Snapshot, require_serialisable

PROJECT = Path(__file__).parents[3]
FMUS = PROJECT / "fmus"
EVENTS = """\
events:
  - {at: 0.02, jitter: {mass.f: 5}, seed: 7, duration: 0.3}
  - {at: 0.15, offset: {mass.f: 0.5}}
  - {when: mass.s_des > 0.05, set: {sensor.sigma: 0.5}, duration: 0.1}
  - {when: mass.s_des > 100, set: {sensor.sigma: 5.0}}
"""
TEXT = """\
name: test
step_size: 0.001
stop_time: 0.4
fmus:
  mass: {source: spacecraft.fmu, parameters: {m_s: 2.0}, start: {v_des: 1.0}}
  sensor: {source: force_sensor.fmu, parameters: {seed: 4, sigma: 0.2}}
"""
SYSTEMS = {
    "delayed wire, events and random numbers": TEXT
    + "coupling: {order: [mass, sensor]}\nconnections: [{from: sensor.f_mea, to: mass.f, delay: 3}]\n"
    + EVENTS,
    "extrapolation and rates": TEXT.replace("spacecraft.fmu,", "spacecraft.fmu, every: 4,")
    + "coupling: {order: [mass, sensor]}\n"
    + "connections: [{from: sensor.f_mea, to: mass.f, extrapolation: 2}]\n",
    "a limit that ends it": TEXT
    + "coupling: {order: [mass, sensor]}\nconnections: [{from: sensor.f_mea, to: mass.f}]\n"
    + "limits: {mass.s_des: 0.3}\n",
}


class Collect:
    """Takes a snapshot whenever it is asked."""

    def __init__(self):
        self.snapshots = []

    def is_due(self):
        return True

    def put(self, snapshot):
        self.snapshots.append(snapshot)


def run(experiment, **more):
    options = RunOptions(
        limits=experiment.limits,
        compared=experiment.compared,
        scenario=experiment.scenario,
        inputs=experiment.inputs,
        **more,
    )
    return simulate(experiment.system, experiment.schedule, experiment.grid, options=options)


def assert_goes_on_with_the_same_bits(experiment):
    collected = Collect()
    whole = run(experiment, checkpoints=collected)
    later = [s for s in collected.snapshots if s.tick > 0]
    assert collected.snapshots[0].tick == 0
    assert later, "no snapshot amid the run"
    for snapshot in (collected.snapshots[0], later[0], later[-1]):
        again = run(experiment, begin_at=Snapshot.from_bytes(snapshot.to_bytes()))

        assert (again.status, again.steps, again.cause) == (whole.status, whole.steps, whole.cause)
        assert again.not_reached == whole.not_reached
        assert again.messages == whole.messages
        assert np.array_equal(again.result.values, whole.result.values[snapshot.tick + 1 :])


@pytest.fixture
def system(tmp_path):
    for name in ("spacecraft.fmu", "force_sensor.fmu"):
        shutil.copy(FMUS / name, tmp_path)

    def write(text):
        path = tmp_path / "system.yaml"
        path.write_text(text, encoding="utf-8")
        return prepare(path)

    return write


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_run_goes_on_from_a_snapshot_with_the_same_bits(system, name):
    assert_goes_on_with_the_same_bits(system(SYSTEMS[name]))


@pytest.mark.parametrize("flavour", ["native", "fmi3", pytest.param("python", marks=pytest.mark.long)])
def test_the_docking_loop_of_each_flavour_goes_on_with_the_same_bits(flavour):
    path = PROJECT / "configs" / "low_frequency.yaml"
    assert_goes_on_with_the_same_bits(prepare(path, Request(stop_time=0.2, flavour=flavour)))


def test_a_snapshot_of_another_system_is_refused(system):
    collected = Collect()
    first = SYSTEMS["extrapolation and rates"]
    run(system(first), checkpoints=collected)
    snapshot = collected.snapshots[0]

    with pytest.raises(DataError, match="does not belong to this system"):
        run(system(first.replace("every: 4", "every: 2")), begin_at=snapshot)


@pytest.mark.parametrize("damage", ["cut", "changed"])
def test_a_damaged_snapshot_is_not_read(system, damage):
    collected = Collect()
    run(system(SYSTEMS["extrapolation and rates"]), checkpoints=collected)
    data = bytearray(collected.snapshots[0].to_bytes())
    if damage == "cut":
        del data[len(data) // 2 :]
    else:
        data[100] ^= 255

    with pytest.raises(ValueError, match="not a snapshot"):
        Snapshot.from_bytes(bytes(data))


def test_an_fmu_that_cannot_write_its_state_is_named(system):
    made = system(SYSTEMS["extrapolation and rates"]).system
    sensor = made.instances["sensor"]
    unable = replace(sensor, description=replace(sensor.description, can_serialise_state=False))
    changed = replace(made, instances={**made.instances, "sensor": unable})
    with pytest.raises(ConfigError) as caught:
        require_serialisable(changed, "--checkpoint")

    assert caught.value.problems == [
        "--checkpoint: sensor: cannot write its state to a file, got no canSerializeFMUstate in "
        "force_sensor.fmu, expected FMUs that can, or a run without checkpoints"
    ]
