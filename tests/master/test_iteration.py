import numpy as np
import pytest
from stubs import Block, bench, clock, integrator, mark, variables, wire

from master.errors import ConfigError

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
