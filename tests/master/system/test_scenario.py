import pytest

from master.stepping.outcome import Happened
from tests.master.system.scenarios import faulted, scenario_of
from tests.stubs import Block, bench, clock, gain, integrator, mark, typed, variables, wire


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


def test_of_events_that_overlap_the_last_one_holds_and_then_the_one_before_it():
    inner = (
        {"at": 1.0, "offset": {"g.u": 10.0}, "for": 5.0},
        {"at": 2.0, "offset": {"g.u": 20.0}, "for": 2.0},
    )
    crossing = (
        {"at": 1.0, "offset": {"g.u": 10.0}, "for": 2.0},
        {"at": 2.0, "offset": {"g.u": 20.0}, "for": 3.0},
    )

    assert seen(*inner) == [0, 1, 12, 23, 24, 15, 16, 7]
    assert seen(*crossing) == [0, 1, 12, 23, 24, 25, 6, 7]


def test_faults_of_different_kinds_act_together():
    events = ({"at": 1.0, "offset": {"g.u": 10.0}}, {"at": 3.0, "delay": {"g.u": 1}, "for": 2.0})

    assert seen(*events) == [0, 1, 12, 13, 13, 14, 16, 17]


def test_values_that_are_set_one_over_the_other_go_back_in_turn():
    made = bench({"x": integrator()})
    first = {"at": 1.0, "set": {"x.u": 1.0}, "for": 3.0}
    second = {"at": 2.0, "set": {"x.u": 5.0}, "for": 4.0}
    result = made.run(8, scenario=scenario_of(made, first, second)).result

    assert result["x.x"].tolist() == [0.0, 0.0, 1.0, 6.0, 11.0, 16.0, 21.0, 21.0, 21.0]


def test_an_event_at_the_start_acts_in_the_first_tick():
    assert seen({"at": 0.0, "offset": {"g.u": 10.0}}, n_ticks=2) == [0, 11, 12]


def test_a_condition_that_is_true_at_the_start_acts_in_the_first_tick():
    assert seen({"when": "clock.t < 0.5", "offset": {"g.u": 10.0}}, n_ticks=2) == [0, 11, 12]


@pytest.mark.parametrize("compiled", [False, True])
def test_conditions_that_come_true_in_one_tick_act_in_the_same_next_one(compiled):
    events = (
        {"when": "clock.t > 1.5", "offset": {"g.u": 10.0}},
        {"when": "g.y > 1.5", "delay": {"g.u": 1}},
    )

    assert seen(*events, n_ticks=4, compiled=compiled) == [0, 1, 2, 12, 13]


def test_a_condition_that_does_not_come_true_is_told():
    made, scenario = faulted(
        {"when": "clock.t > 99", "offset": {"g.u": 1.0}}, {"when": "clock.t > 1", "drop": "g.u"}
    )

    outcome = made.run(4, scenario=scenario)

    assert outcome.not_reached == ["clock.t > 99"]
    assert outcome.happened == [Happened("clock.t > 1", 2.0)]  # row 2 is the first beyond 1


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize(
    ("deed", "integers", "truths"),
    [
        ({"freeze": ["v.i", "v.b"]}, [0, 1, 1, 1, 4], [0, 1, 1, 1, 0]),
        ({"drop": ["v.i", "v.b"]}, [0, 1, 0, 0, 4], [0, 1, 0, 0, 0]),
        ({"delay": {"v.i": 1, "v.b": 1}}, [0, 1, 1, 2, 4], [0, 1, 1, 0, 0]),
        ({"offset": {"v.i": 10.0}}, [0, 1, 12, 13, 4], [0, 1, 0, 1, 0]),
    ],
)
def test_faults_act_on_integers_and_booleans(deed, integers, truths, compiled):
    """The Boolean is true in odd rows."""
    odd = Block(lambda t, h, v: {"y": (t + h) % 2.0}, variables(("y", "output")))
    made = bench({"clock": clock(), "odd": odd, "v": typed()}, [wire("clock.t", "v.i"), wire("odd.y", "v.b")])
    event = {"at": 1.0, "for": 2.0, **deed}
    result = made.run(4, scenario=scenario_of(made, event), compiled=compiled).result

    assert result["v.i_out"].tolist() == integers
    assert result["v.b_out"].tolist() == truths


def iterated(*events, n_ticks=7, **more):
    """As `seen`, with clock and gain in an iterated group."""
    group = {"iterate": ["clock", "g"], "tolerance": 1e-12, "maximum": 5}
    made = bench({"clock": clock(), "g": gain()}, [wire("clock.t", "g.u")], [group])
    outcome = made.run(n_ticks, scenario=scenario_of(made, *events), **more)
    assert outcome.status == "completed", outcome.error
    return outcome.result["g.y"].tolist()


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize(
    "event",
    [
        {"offset": {"g.u": 10.0}, "for": 2.0},
        {"freeze": "g.u"},
        {"drop": "g.u", "for": 2.0},
        {"delay": {"g.u": 2}},
        {"jitter": {"g.u": 2}, "seed": 7},
    ],
)
def test_a_fault_within_an_iterated_group_is_that_of_a_sequence(event, compiled):
    event = {"at": 2.0, **event}

    assert iterated(event, n_ticks=20, compiled=compiled) == seen(event, n_ticks=20)


def test_an_iteration_closes_over_a_value_with_an_offset():
    """The loop p = -(q + 2)/2 + t, q = p is solved by (t - 1) / 1.5."""
    half = Block(
        lambda t, h, v: {"y": -0.5 * v["u"] + v["w"] if h else 0.0},
        variables(("u", "input"), ("w", "input"), ("y", "output")),
    )
    blocks = {"clock": clock(), "p": half, "q": gain()}
    wires = [wire("p.y", "q.u"), wire("q.y", "p.u"), wire("clock.t", "p.w")]
    group = {"iterate": ["p", "q"], "tolerance": 1e-12, "maximum": 100}
    made = bench(blocks, wires, ["clock", group])
    result = made.run(5, scenario=scenario_of(made, {"at": 2.0, "offset": {"p.u": 2.0}})).result

    assert result["q.y"][:3] == pytest.approx([0.0, 1 / 1.5, 2 / 1.5], abs=1e-10)
    assert result["q.y"][3:] == pytest.approx([2 / 1.5, 3 / 1.5, 4 / 1.5], abs=1e-10)


@pytest.mark.parametrize("event", [None, {"at": 900.0, "offset": {"slow.u0": 1.0}}])
@pytest.mark.parametrize("delay", [0, 1])
def test_a_slow_fmu_gets_a_value_one_of_its_steps_on(delay, event):
    """A clock through the extrapolation of order 1 is 3 ticks on, whatever else the wire does."""
    wires = [wire("clock.t", "slow.u0", delay=delay, extrapolation=1)]
    made = bench({"clock": clock(), "slow": mark()}, wires, ["clock", "slow"], every={"slow": 3})
    result = made.run(12, scenario=scenario_of(made, *[event] * (event is not None))).result

    assert result["slow.seen0"][6::3].tolist() == [k - delay + 3 for k in (6, 9, 12)]


def test_an_event_adds_to_the_delay_of_the_connection():
    assert seen({"at": 3.0, "delay": {"g.u": 1}}, delay=1) == [0, 0, 1, 2, 2, 3, 4, 5]
