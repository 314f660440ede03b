"""The fused form is trusted after a completed run of the same bits, and no more once a bit differs."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from master.campaign import proven
from master.campaign import sweep as course
from master.campaign.dataset import read_columns
from master.campaign.fused import FUSED
from master.campaign.plan import make_plan
from master.campaign.proven import COMPARED, FIRST, NO_MEMORY, NOT_EXACT, ProvenRuns
from master.campaign.stepper import Row
from master.fuse.runs import OTHER_START, REFUSED, FusedForm
from master.recording.recorder import Result
from master.stepping.outcome import COMPLETED, DIVERGED, FAILED, TERMINATED, Outcome
from tests.master.fuse.systems import MEMBERS, loop

FORM = FusedForm(Path("none"), np.zeros(0), {})
PLAN = SimpleNamespace(measures={}, signals={}, metrics=(), base=SimpleNamespace(compared=()))


def ended(status=COMPLETED, value=1.0):
    return Outcome(status, Result(np.zeros(1), ("y",), ("1",), np.full((1, 1), value)), 0.0, 1)


@pytest.fixture
def makes(monkeypatch):
    """Let the fused form make what it is told to: an experiment is what becomes of it."""

    class Runs:
        def __init__(self, form, base, kept=None):
            if isinstance(makes.opens, Exception):
                raise makes.opens

        def run(self, experiment):
            if isinstance(experiment, Exception):
                raise experiment
            return experiment

        def close(self):
            pass

    makes = SimpleNamespace(opens=None)
    monkeypatch.setattr(proven, "FusedRuns", Runs)
    return makes


def shown():
    """Runs of a process that has seen the bits of one run."""
    runs = ProvenRuns(PLAN, FORM)
    assert runs.learn(ended(), ended(), runs.run(ended())) == FIRST
    return runs


def test_a_first_run_that_diverges_early_proves_nothing(makes):
    runs = ProvenRuns(PLAN, FORM)
    early = ended(DIVERGED)
    assert runs.learn(early, early, runs.run(early)) == FIRST
    assert runs.run(ended()) == FIRST
    assert runs.learn(ended(value=1.0), ended(value=2.0), FIRST) == NOT_EXACT
    assert runs.run(ended()) == NOT_EXACT


def test_bits_are_compared_again_after_some_runs(makes, monkeypatch):
    monkeypatch.setattr(proven, "EVERY", 3)
    runs = shown()
    for _ in range(2):
        assert [isinstance(runs.run(ended()), Outcome) for _ in range(3)] == [True] * 3
        assert runs.run(ended()) == COMPARED
        assert runs.learn(ended(DIVERGED), ended(DIVERGED), COMPARED) == COMPARED
    assert [isinstance(runs.run(ended()), Outcome) for _ in range(3)] == [True] * 3
    assert runs.learn(ended(value=1.0), ended(value=np.nextafter(1.0, 2.0)), runs.run(ended())) == NOT_EXACT
    assert runs.run(ended()) == NOT_EXACT


@pytest.mark.parametrize("status", [FAILED, TERMINATED])
def test_a_run_that_does_not_end_well_with_the_fmus_either_was_refused(makes, status):
    runs = shown()
    assert runs.learn(REFUSED, ended(status), runs.run(REFUSED)) == REFUSED
    assert isinstance(runs.run(ended()), Outcome)


def test_a_form_that_refuses_what_the_fmus_do_is_not_exact(makes):
    runs = shown()
    assert runs.learn(REFUSED, ended(), runs.run(REFUSED)) == NOT_EXACT
    first = ProvenRuns(PLAN, FORM)
    assert first.learn(REFUSED, ended(), first.run(REFUSED)) == NOT_EXACT


def test_a_start_value_that_the_form_does_not_take_is_no_other_bit(makes):
    runs = shown()
    assert runs.learn(OTHER_START, ended(), runs.run(OTHER_START)) == OTHER_START
    first = ProvenRuns(PLAN, FORM)
    assert first.learn(OTHER_START, ended(), first.run(OTHER_START)) == OTHER_START


def test_where_there_is_no_memory_for_the_form_runs_go_on_without_it(makes):
    runs = shown()
    assert runs.run(MemoryError()) == NO_MEMORY
    assert runs.run(ended()) == NO_MEMORY
    makes.opens = MemoryError()
    assert ProvenRuns(PLAN, FORM).learn(ended(), ended(), FIRST) == NO_MEMORY
    makes.opens = OSError("cut off")
    said = "the library of the fused form cannot be loaded: cut off"
    assert ProvenRuns(PLAN, FORM).learn(ended(), ended(), FIRST) == said


OFF, RIGHT = -1.0, 1.0
APART = "as ordered"


class Engine:
    """Makes runs in the ways named; the values of the fused form are off."""

    restarts = 0

    def __init__(self, *ways):
        self.ways = iter(ways)

    def rows(self, orders, is_over):
        for made, order in zip(self.ways, orders, strict=False):
            assert order.is_apart or made != APART
            yield Row(order.run, COMPLETED, numbers={"y": OFF if made == FUSED else RIGHT}, made=made)

    def close(self):
        pass


def test_rows_that_may_be_off_are_made_again_also_those_of_an_earlier_command(tmp_path, monkeypatch):
    (tmp_path / "system.yaml").write_text(yaml.safe_dump(loop(MEMBERS)))
    campaign = {
        "system": "system.yaml",
        "vary": {"spacecraft.m_s": {"linspace": [300.0, 900.0, 12]}},
        "keep": {"measures": {"y": {"final": "contact.x"}}},
    }
    path = tmp_path / "campaign.yaml"
    path.write_text(yaml.safe_dump(campaign))
    plan = make_plan(path)
    late = FUSED  # of a process that has not heard yet
    engines = iter([Engine(*[FUSED] * 4), Engine(FIRST, FUSED, NOT_EXACT, late, *[APART] * 20)])
    monkeypatch.setattr(course, "_engine", lambda plan, workers, scheduler: (next(engines), 1))

    folder = tmp_path / "out"
    assert course.sweep(plan, folder, 1, page=False).fused == 4
    found = course.sweep(plan, folder, 1, page=False, resume=True)
    columns = read_columns(folder / "runs", ["run", "y"])

    assert columns["run"].tolist() == list(range(12))
    assert columns["y"].tolist() == [RIGHT] * 12
    assert found.statuses == {COMPLETED: 12}
    assert (found.fused, found.discarded) == (0, 5)
    assert found.apart == {FIRST: 1, NOT_EXACT: 1, APART: 10}
