"""A status that is neither OK nor warning ends a run in every call, and is named."""

from __future__ import annotations

import ctypes
import math

import pytest

from master.fmi.status import described
from master.fmi.value_types import FLOAT64
from tests.stubs import EXCHANGE, OK, STEP, Block, Stub, bench, clock, gain, variables, wire

NAMED = {
    -1: "status -1, which FMI does not define, expected 0 to 5",
    2: "status discard: it cannot do this",
    3: "status error",
    4: "status fatal",
    5: "status pending: a step in the background, which the master does not wait for",
    6: "status 6, which FMI does not define, expected 0 to 5",
    77: "status 77, which FMI does not define, expected 0 to 5",
    99: "status 99, which FMI does not define, expected 0 to 5",
    101: "status 101, which FMI does not define, expected 0 to 5",
    -2147483648: "status -2147483648, which FMI does not define, expected 0 to 5",
}
CALLS = {
    "set": "the setter of its inputs",
    "get": "the getter of its outputs",
    "step": "the step",
    "get_state": "the getter of its state",
    "set_state": "the setter of its state",
}


class Answering(Stub):
    """A stub one of whose functions answers with a status from its second call on."""

    def __init__(self, name, description, law, call, status):
        self.call, self.status, self.left = call, status, 1
        super().__init__(name, description, law)

    def _make_c_functions(self):
        made = super()._make_c_functions()
        version = self.description.version
        key = (self.call, FLOAT64) if self.call in ("set", "get") else self.call
        kind = {"set": EXCHANGE[version], "get": EXCHANGE[version], "step": STEP[version]}.get(
            self.call, type(made[key])
        )
        plain = made[key]

        def answer(*given):
            self.left -= 1
            return plain(*given) if self.left >= 0 else self.status

        return made | {key: kind(answer)}


def run(call, status, version, compiled):
    ports = gain().variables
    blocks = {"clock": clock(), "g": Block(gain().law, ports, version=version)}
    order = ["clock", {"iterate": ["g"]}] if "state" in call else ["clock", "g"]
    made = bench(blocks, [wire("clock.t", "g.u")], order)

    def factory(name, description):
        law = blocks[name].law
        if name == "g":
            return Answering(name, description, law, call, status)
        return Stub(name, description, law)

    made.factory = factory
    return made.run(5, compiled=compiled)


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("status", NAMED)
def test_a_status_ends_the_run_in_every_call_and_is_named_with_it(status, call, version, compiled):
    outcome = run(call, status, version, compiled)

    assert (outcome.status, outcome.steps) == ("failed", 1)
    assert str(outcome.error) == f"g at t=1 s: {CALLS[call]} answered with {NAMED[status]}"
    assert described(status) == NAMED[status]


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("call", CALLS)
def test_a_warning_ends_no_run(call, compiled):
    outcome = run(call, 1, 2, compiled)

    assert (outcome.status, outcome.steps) == ("completed", 5)


class Timeless(Stub):
    """A clock of FMI 3.0 that gives a time reached that is not a number, with or without an early return."""

    early = False

    def _make_c_functions(self):
        def step(component, t, h, _, events, end, early, last):
            self.values["t"] = t + h
            ctypes.c_bool.from_address(early).value = self.early
            ctypes.c_double.from_address(last).value = math.nan if t >= 2.0 else t + h
            return OK

        return super()._make_c_functions() | {"step": STEP[3](step)}


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("early", [False, True])
def test_a_last_successful_time_that_is_not_a_number_is_an_error(early, compiled):
    block = Block(lambda t, h, v: {"t": t + h}, variables(("t", "output")), version=3)
    made = bench({"a": block})
    kind = type("Own", (Timeless,), {"early": early})
    made.factory = lambda name, description: kind(name, description, block.law)
    outcome = made.run(5, compiled=compiled)

    assert (outcome.status, outcome.steps) == ("failed", 2)
    assert "a at t=2 s: the last successful time of a step is not a number" in str(outcome.error)


class Stateless(Stub):
    """A stub that says OK when it is asked for its state, and gives none."""

    def _get_state(self, _, place):
        place[0] = None
        return 0


@pytest.mark.parametrize("compiled", [False, True])
def test_a_state_that_is_not_there_is_no_state_to_go_back_to(compiled):
    made = bench({"clock": clock(), "g": gain()}, [wire("clock.t", "g.u")], ["clock", {"iterate": ["g"]}])
    made.factory = lambda name, description: (Stateless if name == "g" else Stub)(
        name, description, made.blocks[name].law
    )
    outcome = made.run(5, compiled=compiled)

    assert (outcome.status, outcome.steps) == ("failed", 0)
    assert str(outcome.error) == (
        "g at t=0 s: the getter of its state gave none, expected a state to go back to"
    )
