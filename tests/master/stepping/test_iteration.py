import numpy as np
import pytest

from master.errors import ConfigError
from tests.stubs import Block, bench, clock, integrator, mark, variables, wire

PORTS = variables(("u", "input"), ("w", "input"), ("y", "output"))


def affine(factor):
    """Output y = factor*u + w in a step, 0 at the start: no algebraic loop there."""
    return Block(lambda t, h, v: {"y": factor * v["u"] + v["w"] if h else 0.0}, PORTS)


def loop(factor, **more):
    """The loop p = factor*q + t, q = p: solved by t/(1 - factor)."""
    blocks = {"clock": clock(), "p": affine(factor), "q": affine(1.0)}
    wires = [wire("p.y", "q.u", **more), wire("q.y", "p.u"), wire("clock.t", "p.w")]
    return blocks, wires


@pytest.mark.parametrize("compiled", [False, True])
def test_an_algebraic_loop_comes_to_its_solution(compiled):
    group = {"iterate": ["p", "q"], "tolerance": 1e-12, "maximum": 100}
    outcome = bench(*loop(-0.5), ["clock", group]).run(6, compiled=compiled)

    assert outcome.status == "completed"
    assert outcome.result["q.y"] == pytest.approx(np.arange(7) / 1.5, abs=1e-11)


def test_states_are_put_back_before_each_pass():
    blocks = {"mass": integrator(), "spring": affine(-0.5)}
    wires = [wire("mass.x", "spring.u"), wire("spring.y", "mass.u")]
    group = {"iterate": ["mass", "spring"], "tolerance": 1e-13, "maximum": 100}
    made = bench(blocks, wires, [group], step_size=0.1, start={"mass": {"x": 1.0}})
    result = made.run(20).result

    # implicit Euler for x' = -x/2: x(k+1) = x(k) - h/2 x(k+1)
    assert result["mass.x"] == pytest.approx(1.05 ** -np.arange(21.0), abs=1e-11)


def test_a_wire_in_an_iterated_group_is_not_old():
    blocks = {"a": mark(1), "b": mark(1)}
    wires = [wire("a.row", "b.u0"), wire("b.row", "a.u0")]
    made = bench(blocks, wires, [{"iterate": ["a", "b"]}])
    result = made.run(5).result

    assert [(e.least, e.most) for e in made.ledger.entries] == [(0, 0), (0, 0)]
    assert result["a.seen0"][1:].tolist() == result["b.seen0"][1:].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]


def test_an_iterated_group_has_one_rate():
    with pytest.raises(ConfigError) as caught:
        bench(*loop(-0.5), ["clock", {"iterate": ["p", "q"]}], every={"p": 2})

    assert caught.value.problems == ["coupling.order: an iterated group has one rate, got every [1, 2] ticks"]


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("factor", [-0.9, -0.5, 0.0, 0.5, 0.9])
def test_the_solution_of_an_algebraic_loop_is_right_to_ten_digits(factor, compiled):
    group = {"iterate": ["p", "q"], "tolerance": 1e-12, "maximum": 500}
    outcome = bench(*loop(factor), ["clock", group]).run(5, compiled=compiled)

    # the error is at most factor/(1 - factor) times the residual: 9e-12 relative to nominal 1
    assert outcome.result["q.y"] == pytest.approx(np.arange(6) / (1.0 - factor), abs=1e-10)


@pytest.mark.parametrize("compiled", [False, True])
def test_a_diverging_loop_is_reported_with_wire_and_residual(compiled):
    group = {"iterate": ["p", "q"], "tolerance": 1e-6, "maximum": 3}
    outcome = bench(*loop(-2.0), ["clock", group]).run(5, compiled=compiled)

    # q of the passes at t = 1: 1, -1, 3; p is sent 3 where it took -1
    assert (outcome.status, outcome.steps) == ("failed", 0)
    problem = "the iteration over q.y -> p.u does not converge, got a residual of 4, expected at most 1e-06"
    assert str(outcome.error) == f"q at t=0 s: {problem}"


def test_the_tolerance_of_a_connection_stands_over_that_of_its_group():
    blocks, wires = loop(-0.5)
    group = {"iterate": ["p", "q"], "tolerance": 1e-13, "maximum": 100}
    exact = bench(blocks, wires, ["clock", group]).run(1).result["q.y"][1]
    loose = [{**w, "tolerance": 0.3} if w["from"] == "q.y" else w for w in wires]
    early = bench(blocks, loose, ["clock", group]).run(1).result["q.y"][1]

    # passes give 1, 0.5, 0.75: the last differs from the one before by 0.25 < 0.3
    assert exact == pytest.approx(2.0 / 3.0, abs=1e-12)
    assert early == 0.75


def test_a_tolerance_is_relative_to_the_nominal_value_of_the_input():
    ports = variables(("u", "input", {"nominal": 1000.0}), ("w", "input"), ("y", "output"))
    blocks, wires = loop(-0.5)
    blocks["p"] = Block(blocks["p"].law, ports)
    group = {"iterate": ["p", "q"], "tolerance": 3e-4, "maximum": 100}

    assert bench(blocks, wires, ["clock", group]).run(1).result["q.y"][1] == 0.75


def test_a_delay_and_a_rate_beside_an_iterated_group_are_as_without_it():
    blocks, wires = loop(-0.5)
    blocks |= {"slow": mark(1), "late": mark(1)}
    wires = [*wires, wire("q.y", "slow.u0"), wire("clock.t", "late.u0", delay=2)]
    group = {"iterate": ["p", "q"], "tolerance": 1e-13, "maximum": 100}
    made = bench(blocks, wires, ["clock", group, "slow", "late"], every={"slow": 3})
    result = made.run(9).result

    k = np.arange(10)
    assert result["slow.seen0"] == pytest.approx(k // 3 * 3 / 1.5, abs=1e-11)
    assert result["late.seen0"].tolist() == np.maximum(0, k - 2).tolist()


def test_a_delayed_wire_in_an_iterated_group_is_not_iterated():
    blocks = {"clock": clock(), "p": affine(-2.0), "q": affine(1.0)}
    wires = [wire("p.y", "q.u"), wire("q.y", "p.u", delay=1), wire("clock.t", "p.w")]
    made = bench(blocks, wires, ["clock", {"iterate": ["p", "q"]}])
    result = made.run(4).result

    assert [(e.least, e.most) for e in made.ledger.entries] == [(0, 0), (2, 2), (0, 0)]
    assert result["q.y"].tolist() == [0.0, 1.0, 2.0, 1.0, 0.0]  # q(k) = k - 2 q(k-2)


def test_a_group_that_steps_every_other_tick_iterates_then():
    group = {"iterate": ["p", "q"], "tolerance": 1e-13, "maximum": 100}
    result = bench(*loop(-0.5), ["clock", group], every={"p": 2, "q": 2}).run(6).result

    assert result["q.y"] == pytest.approx(np.arange(7) // 2 * 2 / 1.5, abs=1e-11)


def test_saved_states_are_freed_after_the_run():
    made = bench(*loop(-0.5), ["clock", {"iterate": ["p", "q"]}])
    made.run(3)

    assert [slave.states for slave in made.slaves.values()] == [{}, {}, {}]
