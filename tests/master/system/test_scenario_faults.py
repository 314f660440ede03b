import pytest
from pydantic import ValidationError

from master.errors import ConfigError
from master.fmi.description import Kind
from tests.master.system.scenarios import STOP, faulted, scenario_of
from tests.stubs import Block, bench, clock, typed, variables, wire


@pytest.mark.parametrize(
    ("event", "problem"),
    [
        ({"at": 0.0, "freeze": "g.y"}, "g.y: not a connected input, expected one of g.u"),
        ({"at": 0.0, "set": {"g.u": 1.0}}, "set: g.u is connected, expected offset, freeze or drop for it"),
        (
            {"when": "clock.t = 3", "freeze": "g.u"},
            "when: not a condition, got 'clock.t = 3', expected 'instance.variable > number'",
        ),
        ({"when": "clock.t > x", "freeze": "g.u"}, "when: not a number, got 'x', expected a threshold"),
        (
            {"when": "clock.x > 1", "freeze": "g.u"},
            "when: no such output of clock (clock), got 'x', expected one of t",
        ),
        ({"when": "clock.t > nan", "freeze": "g.u"}, "when: not a number, got 'nan', expected a threshold"),
        ({"at": 1.0}, "does nothing, expected one of set, offset, freeze, drop, delay, jitter"),
        (
            {"at": STOP, "freeze": "g.u"},
            "not within the run, got at 1000 s, expected from 0 s to before 1000 s",
        ),
        (
            {"at": -1.0, "freeze": "g.u"},
            "not within the run, got at -1 s, expected from 0 s to before 1000 s",
        ),
        (
            {"at": 0.0, "set": {"g.y": 1.0}},
            "set: no such parameter or input of g (g), got 'y', expected one of u",
        ),
    ],
)
def test_a_fault_of_an_event_is_named(event, problem):
    with pytest.raises(ConfigError) as caught:
        faulted(event)

    [said] = caught.value.problems
    assert said.split(": ", 2)[2] == problem or said.endswith(problem)


def test_a_fixed_parameter_is_not_set_during_a_run():
    ports = variables(("k", "parameter", {"variability": "fixed"}), ("y", "output"))
    made = bench({"a": Block(lambda t, h, v: {}, ports)})

    with pytest.raises(ConfigError, match=r"set: a\.k is fixed during a run, expected a tunable parameter"):
        scenario_of(made, {"at": 0.0, "set": {"a.k": 1.0}})


@pytest.mark.parametrize(
    ("event", "problem"),
    [
        ({"offset": {"v.b": 1.0}}, "offset: v.b is a Boolean, expected freeze, drop, delay or jitter for it"),
        ({"offset": {"v.i": 0.5}}, "offset: v.i is an integer, got 0.5, expected a whole number"),
        ({"set": {"v.r": "x"}}, "set: v.r: value not allowed, got 'x', expected a number"),
        ({"set": {"w.name": "x"}}, "set: w.name is a string, expected a number or a Boolean during a run"),
    ],
)
def test_what_a_type_does_not_bear_is_named(event, problem):
    name = ("name", "parameter", {"kind": Kind.STRING, "variability": "tunable"})
    blocks = {"clock": clock(), "v": typed(), "w": Block(lambda t, h, v: {}, variables(name))}
    made = bench(blocks, [wire("clock.t", "v.i"), wire("clock.t", "v.b")])
    with pytest.raises(ConfigError) as caught:
        scenario_of(made, {"at": 0.0, **event})

    assert caught.value.problems == [f"bench.yaml:1: events[0]: {problem}"]


@pytest.mark.parametrize(
    "event",
    [
        {"at": float("nan"), "freeze": "g.u"},
        {"at": 0.0, "freeze": "g.u", "for": float("inf")},
        {"at": 0.0, "offset": {"g.u": float("nan")}},
        {"at": 0.0, "delay": {"g.u": 10**12}},
        {"at": 0.0, "when": "clock.t > 1", "freeze": "g.u"},
        {"freeze": "g.u"},
        {"at": 0.0, "jitter": {"g.u": 1}, "seed": 0},
    ],
)
def test_a_number_that_no_run_bears_is_refused(event):
    with pytest.raises(ValidationError):
        faulted(event)


def test_all_faults_of_all_events_are_reported():
    with pytest.raises(ConfigError) as caught:
        faulted({"at": 0.0, "freeze": "g.x"}, {"at": 0.0, "drop": "g.z"})

    assert len(caught.value.problems) == 2
