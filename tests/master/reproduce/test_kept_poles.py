"""Poles are kept by all that they depend on, and not for ever."""

from __future__ import annotations

from dataclasses import replace

import pytest

from master.coupling.methods.iterated import Iterated
from master.coupling.methods.side_by_side import SideBySide
from master.coupling.methods.waveform import Waveform
from master.experiment.experiment import Experiment
from master.reproduce.measures import poles
from master.reproduce.measures.poles import _asked
from tests.stubs import bench, gain, wire


@pytest.fixture
def experiment():
    made = bench({"a": gain(), "b": gain()}, [wire("a.y", "b.u"), wire("b.y", "a.u")], ["a", "b"])
    return Experiment(made.loaded.config, None, made.system, made.schedule)


def with_start(experiment, **start):
    instances = experiment.system.instances
    changed = replace(instances["a"], start={**instances["a"].start, **start})
    return replace(experiment, system=replace(experiment.system, instances={**instances, "a": changed}))


def with_delay(experiment):
    first, second = experiment.system.wires
    return replace(experiment, system=replace(experiment.system, wires=(replace(first, delay=1), second)))


def with_schedule(experiment, **changes):
    return replace(experiment, schedule=replace(experiment.schedule, **changes))


CHANGES = {
    "delay": with_delay,
    "every": lambda e: with_schedule(e, every={"a": 1, "b": 2}),
    "iterated": lambda e: with_schedule(e, groups=(Iterated(iterate=("a", "b")),)),
    "side by side": lambda e: with_schedule(e, groups=(SideBySide(members=("a", "b")),)),
    "waveforms": lambda e: with_schedule(e, groups=(Waveform(waveform=("a", "b"), window=2),)),
    "step size": lambda e: replace(e, config=e.config.model_copy(update={"step_size": 0.5})),
    "parameter": lambda e: with_start(e, u=0.25),
}


@pytest.mark.parametrize("one", CHANGES)
@pytest.mark.parametrize("other", CHANGES)
def test_systems_that_differ_do_not_share_their_poles(experiment, one, other):
    first, second = (_asked(CHANGES[name](experiment)) for name in (one, other))

    assert first != _asked(experiment)
    assert (first == second) == (one == other)


def test_noise_has_no_part_in_the_poles(experiment):
    assert _asked(with_start(experiment, seed=7.0, sigma=0.5)) == _asked(experiment)
    assert hash(_asked(with_start(experiment, seed=7.0))) == hash(_asked(experiment))


@pytest.mark.parametrize("kept", [poles._judged, poles._cancellation])
def test_the_number_of_kept_answers_is_bounded(kept):
    assert kept.cache_parameters()["maxsize"] == 64
    assert not hasattr(poles, "_KEYS")
