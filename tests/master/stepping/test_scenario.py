import pytest
from stubs import Block, bench, clock, gain, integrator, variables, wire

from master.errors import ConfigError
from master.stepping.scenario import make_scenario
from master.system.config import Config, LoadedConfig


def faulted(*events, **more):
    """A clock seen through a connected gain, under events; the step is 1 s, so that t is the row."""
    made = bench({"clock": clock(), "g": gain()}, [wire("clock.t", "g.u", **more)], ["clock", "g"])
    return made, scenario_of(made, *events)


def scenario_of(made, *events):
    config = made.loaded.config.model_dump(by_alias=True) | {"events": list(events)}
    loaded = LoadedConfig(config=Config.model_validate(config), document=made.loaded.document)
    return make_scenario(loaded, made.system)


def seen(*events, n_ticks=7, compiled=False, **more):
    made, scenario = faulted(*events, **more)
    return made.run(n_ticks, scenario=scenario, compiled=compiled).result["g.y"].tolist()


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize(
    ("event", "expected"),
    [
        ({"offset": {"g.u": 10.0}}, [0, 1, 2, 13, 14, 15, 16, 17]),
        ({"offset": {"g.u": 10.0}, "for": 2.0}, [0, 1, 2, 13, 14, 5, 6, 7]),
        ({"freeze": ["g.u"], "for": 3.0}, [0, 1, 2, 2, 2, 2, 6, 7]),
        ({"freeze": "g.u"}, [0, 1, 2, 2, 2, 2, 2, 2]),
        ({"drop": "g.u", "for": 2.0}, [0, 1, 2, 0, 0, 5, 6, 7]),
        ({"delay": {"g.u": 2}}, [0, 1, 2, 1, 2, 3, 4, 5]),
        ({"delay": {"g.u": 1}, "for": 2.0}, [0, 1, 2, 2, 3, 5, 6, 7]),
    ],
)
def test_a_fault_at_two_seconds_acts_from_the_next_row_on(event, expected, compiled):
    assert seen({"at": 2.0, **event}, compiled=compiled) == expected


def test_a_dropped_connection_gives_the_start_value_of_the_input():
    blocks = {
        "clock": clock(),
        "g": Block(
            lambda t, h, v: {"y": v["u"]},
            variables(("u", "input", {"start": "9"}), ("y", "output")),
            {"y": ("u",)},
        ),
    }
    made = bench(blocks, [wire("clock.t", "g.u")], ["clock", "g"])
    result = made.run(4, scenario=scenario_of(made, {"at": 1.0, "drop": "g.u", "for": 2.0})).result

    assert result["g.y"].tolist() == [0.0, 1.0, 9.0, 9.0, 4.0]


def test_a_condition_fires_once_from_the_tick_after_it_came_true():
    event = {"when": "clock.t > 2.5", "offset": {"g.u": 10.0}, "for": 2.0}

    assert seen(event) == [0, 1, 2, 3, 14, 15, 6, 7]


def test_a_condition_may_look_downwards():
    blocks = {"x": integrator(), "g": gain()}
    made = bench(blocks, [wire("x.x", "g.u")], ["x", "g"], start={"x": {"x": 2.0, "u": -1.0}})
    scenario = scenario_of(made, {"when": "x.x < 0.5", "offset": {"g.u": 10.0}})

    assert made.run(4, scenario=scenario).result["g.y"].tolist() == [2.0, 1.0, 0.0, 9.0, 8.0]


def test_set_changes_an_input_without_a_wire_and_goes_back():
    made = bench({"x": integrator()})
    scenario = scenario_of(made, {"at": 1.0, "set": {"x.u": 3.0}, "for": 2.0})

    assert made.run(5, scenario=scenario).result["x.x"].tolist() == [0.0, 0.0, 3.0, 6.0, 6.0, 6.0]


def test_set_changes_a_tunable_parameter():
    ports = variables(("k", "parameter", {"variability": "tunable", "start": "1"}), ("y", "output"))
    made = bench({"a": Block(lambda t, h, v: {"y": v["k"]}, ports)})
    scenario = scenario_of(made, {"at": 2.0, "set": {"a.k": 5.0}})

    assert made.run(4, scenario=scenario).result["a.y"].tolist() == [1.0, 1.0, 1.0, 5.0, 5.0]


def park_miller(seed, n):
    """The generator's numbers, from its definition."""
    numbers = []
    for _ in range(n):
        seed = 48271 * seed % 2147483647
        numbers.append(seed)
    return numbers


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("seed", [1, 77])
def test_jitter_ages_values_by_the_numbers_of_its_seed(seed, compiled):
    got = seen({"at": 4.0, "jitter": {"g.u": 2}, "seed": seed}, n_ticks=24, compiled=compiled)
    ages = [number % 3 for number in park_miller(seed, 20)]

    assert got[:5] == [0, 1, 2, 3, 4]
    assert [k - value for k, value in enumerate(got)][5:] == ages
    assert set(ages) == {0, 1, 2}


def test_two_events_of_one_instant_both_act_and_an_ending_comes_first():
    events = (
        {"at": 1.0, "offset": {"g.u": 10.0}, "for": 2.0},
        {"at": 3.0, "offset": {"g.u": 20.0}, "for": 1.0},
    )

    assert seen(*events, n_ticks=6) == [0, 1, 12, 13, 24, 5, 6]


def test_an_event_adds_to_the_delay_of_the_connection():
    assert seen({"at": 3.0, "delay": {"g.u": 1}}, delay=1) == [0, 0, 1, 2, 2, 3, 4, 5]


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


def test_all_faults_of_all_events_are_reported():
    with pytest.raises(ConfigError) as caught:
        faulted({"at": 0.0, "freeze": "g.x"}, {"at": 0.0, "drop": "g.z"})

    assert len(caught.value.problems) == 2
