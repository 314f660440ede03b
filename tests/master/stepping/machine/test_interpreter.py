import numpy as np
import pytest

from master.fmi.value_types import FLOAT32, INT32, INT64, UINT8
from tests.stubs import (
    DISCARD,
    ERROR,
    FATAL,
    WARNING,
    Block,
    bench,
    clock,
    failing,
    gain,
    integrator,
    typed,
    variables,
    wire,
)


def chain(order):
    """A chain clock -> a -> b -> c, each passing on what it gets."""
    wires = [wire("clock.t", "a.u"), wire("a.y", "b.u"), wire("b.y", "c.u")]
    return bench({"clock": clock(), "a": gain(), "b": gain(), "c": gain()}, wires, order)


@pytest.mark.parametrize("compiled", [False, True])
def test_row_k_holds_the_values_at_t_k(compiled):
    outcome = bench({"clock": clock()}, step_size=0.125).run(8, t0=3.0, compiled=compiled)

    assert outcome.result.time.tolist() == [3.0 + 0.125 * k for k in range(9)]
    assert outcome.result["clock.t"].tolist() == outcome.result.time.tolist()


def test_time_does_not_accumulate():
    outcome = bench({"clock": clock()}, step_size=0.1).run(1000)

    assert outcome.result.time[1000] == 1000 * 0.1
    assert outcome.result["clock.t"][1000] == 999 * 0.1 + 0.1


def test_a_sequence_along_the_wires_passes_a_chain_in_one_step():
    result = chain(["clock", "a", "b", "c"]).run(4).result

    assert result["c.y"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_side_by_side_delays_each_wire_by_one_step():
    result = chain([["clock", "a", "b", "c"]]).run(6).result

    assert result["a.y"].tolist() == [0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert result["b.y"].tolist() == [0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0]
    assert result["c.y"].tolist() == [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0]


def test_a_sequence_against_the_wires_delays_each_wire_by_one_step():
    result = chain(["c", "b", "a", "clock"]).run(6).result

    assert result["c.y"].tolist() == [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0]


def test_a_group_sees_the_newest_values_of_the_groups_before_it():
    result = chain(["clock", ["a", "b"], "c"]).run(4).result

    assert result["a.y"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert result["b.y"].tolist() == [0.0, 0.0, 1.0, 2.0, 3.0]
    assert result["c.y"].tolist() == result["b.y"].tolist()


def test_members_of_a_group_do_not_depend_on_their_order_in_it():
    one = chain([["clock", "a", "b", "c"]]).run(5).result
    other = chain([["b", "c", "clock", "a"]]).run(5).result

    assert np.array_equal(one.values, other.values)


def test_a_delay_adds_whole_steps():
    blocks = {"clock": clock(), "a": gain()}
    result = bench(blocks, [wire("clock.t", "a.u", delay=2)]).run(5, t0=7.0).result

    assert result["a.y"].tolist() == [7.0, 7.0, 7.0, 8.0, 9.0, 10.0]


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize(("order", "law"), [(1, lambda t: 3 * t - 1), (2, lambda t: t * t - 2 * t)])
def test_extrapolation_of_an_order_is_exact_on_a_polynomial_of_that_order(order, law, compiled):
    blocks = {"a": Block(lambda t, h, v: {"y": law(t + h)}, variables(("y", "output"))), "b": gain()}
    made = bench(blocks, [wire("a.y", "b.u", extrapolation=order)], [["a", "b"]])
    result = made.run(8, compiled=compiled).result

    first_exact = order + 2  # row 0 and `order` steps fill the memory
    assert result["b.y"][first_exact:].tolist() == [law(t) for t in result.time[first_exact:]]


def test_an_fmu_at_every_third_tick_steps_at_the_last_of_the_three():
    result = bench({"clock": clock()}, every={"clock": 3}).run(7).result

    assert result["clock.t"].tolist() == [0.0, 0.0, 0.0, 3.0, 3.0, 3.0, 6.0, 6.0]


def test_an_integrator_sums_what_it_gets():
    blocks = {"clock": clock(), "sum": integrator()}
    result = bench(blocks, [wire("clock.t", "sum.u")], step_size=0.5).run(4).result

    assert result["sum.x"].tolist() == [0.0, 0.25, 0.75, 1.5, 2.5]


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("types", [(2, INT32), (3, INT32), (3, INT64), (3, UINT8, FLOAT32)])
def test_reals_round_on_their_way_into_integers_and_become_booleans(types, compiled):
    blocks = {"clock": clock(), "typed": typed(*types)}
    wires = [wire("clock.t", "typed.i"), wire("clock.t", "typed.b"), wire("clock.t", "typed.r")]
    result = bench(blocks, wires, step_size=0.75).run(3, compiled=compiled).result

    assert result["typed.i_out"].tolist() == [0.0, 1.0, 2.0, 2.0]
    assert result["typed.b_out"].tolist() == [0.0, 1.0, 1.0, 1.0]
    assert result["typed.r_out"].tolist() == [0.0, 0.75, 1.5, 2.25]
    assert result["typed.count"].tolist() == [0.0, 1.0, 2.0, 3.0]


def test_integers_and_booleans_pass_between_fmus_of_both_versions():
    blocks = {"first": typed(2), "second": typed(3, INT64)}
    wires = [wire("first.count", "second.i"), wire("first.count", "second.b")]
    result = bench(blocks, wires).run(3).result

    assert result["second.i_out"].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert result["second.b_out"].tolist() == [0.0, 1.0, 1.0, 1.0]


def test_compiled_and_uncompiled_loop_agree_to_the_last_bit():
    blocks = {"a": integrator(), "b": integrator(), "g": gain(-0.7), "typed": typed()}
    wires = [
        wire("b.x", "a.u", delay=2),
        wire("a.x", "g.u"),
        wire("g.y", "b.u"),
        wire("a.x", "typed.i"),
        wire("a.x", "typed.b"),
        wire("g.y", "typed.r"),
    ]
    made = bench(
        blocks, wires, ["a", ["g", "b"], "typed"], step_size=0.1, every={"b": 3}, start={"a": {"x": 1.0 / 3}}
    )
    one, other = made.run(400, compiled=True).result, made.run(400, compiled=False).result

    assert np.array_equal(one.values, other.values)
    assert np.ptp(one["a.x"]) > 0.3


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize(("status", "name"), [(DISCARD, "discard"), (ERROR, "error"), (FATAL, "fatal")])
def test_a_status_worse_than_warning_ends_the_run(status, name, compiled):
    made = bench({"clock": clock(), "bad": failing(0.5, status, "rope torn")}, step_size=0.25)
    outcome = made.run(8, compiled=compiled)

    assert (outcome.status, outcome.steps) == ("failed", 2)
    assert outcome.result["bad.t"].tolist() == [0.0, 0.25, 0.5]
    assert (outcome.error.instance, outcome.error.time, outcome.error.status) == ("bad", 0.5, name)
    more = {
        DISCARD: " (the step answered with status discard: it cannot do this)",
        ERROR: "",
        FATAL: " (the step answered with status fatal)",
    }
    assert str(outcome.error) == f"bad at t=0.5 s: rope torn{more[status]}"


@pytest.mark.parametrize("compiled", [False, True])
def test_an_fmu_without_a_port_steps(compiled):
    seen = []
    blind = Block(lambda t, h, v: seen.append(t) or {}, ())
    outcome = bench({"blind": blind}).run(3, compiled=compiled)

    assert (outcome.status, outcome.steps) == ("completed", 3)
    assert seen[-3:] == [0.0, 1.0, 2.0]


def test_a_status_without_a_message_is_named():
    outcome = bench({"bad": failing(2.0, DISCARD)}).run(4)

    assert str(outcome.error) == "bad at t=2 s: the step answered with status discard: it cannot do this"


def test_a_warning_does_not_end_the_run():
    outcome = bench({"warned": failing(2.0, WARNING)}).run(4)

    assert (outcome.status, outcome.steps) == ("completed", 4)
