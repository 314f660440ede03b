"""What an FMU 3.0 answers to a step beside its status: early return, end of the simulation, event mode."""

import ctypes

import pytest

from master.stepping.machine import operations
from tests.stubs import OK, STEP, Block, Stub, bench, clock, variables


class Answering(Stub):
    """A clock of FMI 3.0 whose steps get to the times that `reached` gives, with the answers of `answers`."""

    def __init__(self, name, description, law, answers):
        self.answers, self.calls = answers, []
        super().__init__(name, description, law)

    def _make_c_functions(self):
        return super()._make_c_functions() | {"step": STEP[3](self._answer)}

    def _answer(self, component, t, h, _, *places):
        events, end, early, last = places
        self.calls.append((t, h))
        reached, flags = self.answers(t, t + h)
        self.values["t"] = reached
        for place, flag in zip((events, end, early), flags, strict=True):
            ctypes.c_bool.from_address(place).value = flag
        ctypes.c_double.from_address(last).value = reached
        return OK


PLAIN = (False, False, False)


def run(answers, compiled, n_ticks=4):
    block = Block(lambda t, h, v: {"t": t + h}, variables(("t", "output")), version=3)
    made = bench({"a": block, "b": clock()}, order=["a", "b"])
    stubs = {}

    def factory(name, description):
        law = made.blocks[name].law
        stubs[name] = (
            Answering(name, description, law, answers) if name == "a" else Stub(name, description, law)
        )
        return stubs[name]

    made.factory = factory
    return made.run(n_ticks, compiled=compiled), stubs["a"].calls


pytestmark = pytest.mark.parametrize("compiled", [False, True])


def test_an_early_return_is_stepped_on_to_the_end_of_the_step(compiled):
    def answers(t, end):
        return (t + 0.25, (False, False, True)) if t == 1.0 else (end, PLAIN)

    outcome, calls = run(answers, compiled)

    assert outcome.status == "completed"
    assert calls == [(0.0, 1.0), (1.0, 1.0), (1.25, 0.75), (2.0, 1.0), (3.0, 1.0)]
    assert outcome.result["a.t"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_an_early_return_at_the_end_of_the_step_is_no_early_return(compiled):
    outcome, calls = run(lambda t, end: (end, (False, False, True)), compiled)

    assert (outcome.status, len(calls)) == ("completed", 4)


def test_an_early_return_without_getting_on_ends_the_run(compiled):
    outcome, calls = run(lambda t, end: (t, (False, False, True)), compiled)

    assert (outcome.status, outcome.steps, len(calls)) == ("failed", 0, 1)
    assert "without getting on" in str(outcome.error)


def test_an_fmu_that_returns_early_again_and_again_ends_the_run(compiled, monkeypatch):
    if not compiled:  # compiled code holds the number; a million returns to Python would take a while
        monkeypatch.setattr(operations, "MOST_RETURNS", 1000)
    outcome, calls = run(lambda t, end: (t + 1e-6 * (end - t), (False, False, True)), compiled, n_ticks=1)

    assert (outcome.status, outcome.steps) == ("failed", 0)
    assert len(calls) == (10**6 if compiled else 1000) + 1
    assert "returned early from a step again and again" in str(outcome.error)


def test_an_end_at_the_end_of_a_step_keeps_its_row_whole(compiled):
    outcome, _ = run(lambda t, end: (end, (False, t == 1.0, False)), compiled)

    assert (outcome.status, outcome.steps) == ("terminated", 2)
    assert outcome.result["b.t"].tolist() == outcome.result["a.t"].tolist() == [0.0, 1.0, 2.0]
    assert outcome.cause == "a at t=2 s: asks for the end of the simulation"


def test_an_end_within_a_step_keeps_the_rows_before_it(compiled):
    outcome, _ = run(lambda t, end: (t + 0.5, (False, True, True)) if t == 1.0 else (end, PLAIN), compiled)

    assert (outcome.status, outcome.steps) == ("terminated", 1)
    assert outcome.result["b.t"].tolist() == [0.0, 1.0]


def test_an_end_after_an_early_return_is_seen(compiled):
    def answers(t, end):
        return (t + 0.5, (False, False, True)) if t == 1.0 else (end, (False, t == 1.5, False))

    outcome, _ = run(answers, compiled)

    assert (outcome.status, outcome.steps) == ("terminated", 2)


def test_event_mode_that_was_not_given_is_refused(compiled):
    outcome, _ = run(lambda t, end: (end, (t == 2.0, False, False)), compiled)

    assert (outcome.status, outcome.steps) == ("failed", 2)
    assert str(outcome.error).startswith("a at t=2 s: asks for event mode, which it was not given")
