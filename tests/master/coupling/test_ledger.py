import numpy as np
import pytest

from master.coupling.ledger import MOST_LOOPS
from master.fmi.description import DeclaredDelay
from tests.stubs import Block, bench, clock, gain, integrator, mark, variables, wire

TRANSIENT, TICKS = 24, 60


def observed_ages(made, n_ticks=TICKS):
    """Least and most age in rows that each target saw: its own row less the row of what it received."""
    result = made.run(n_ticks).result
    found = []
    for joined in made.system.wires:
        target, port = joined.target.instance, joined.target.variable.name
        rows = np.arange(n_ticks + 1)
        stepped = rows[(rows % made.schedule.every[target] == 0) & (rows >= TRANSIENT)]
        ages = stepped - result[f"{target}.{port.replace('u', 'seen')}"][stepped]
        found.append((ages.min(), ages.max()))
    return found


def stated_ages(made):
    return [(e.least, e.most) for e in made.ledger.entries]


@pytest.mark.parametrize(
    ("order", "delay", "steps"),
    [
        (["a", "b"], 0, 0),
        (["b", "a"], 0, 1),
        ([["a", "b"]], 0, 1),
        (["a", "b"], 3, 3),
        (["b", "a"], 2, 3),
        ([["b", "a"]], 1, 2),
    ],
)
def test_an_entry_is_order_plus_delay_and_a_mark_shows_it(order, delay, steps):
    made = bench({"a": mark(0), "b": mark(1)}, [wire("a.row", "b.u0", delay=delay)], order)

    assert stated_ages(made) == [(steps, steps)]
    assert observed_ages(made) == [(steps, steps)]


def test_rates_of_any_size_are_counted_at_once():
    """Of 6 and 4 hundred million ticks 2 are the divisor: a value is 0, 2 or 4 old when it is used."""
    n = 10**8
    every = {"a": 6 * n, "b": 4 * n}
    made = bench({"a": mark(0), "b": mark(1)}, [wire("a.row", "b.u0")], ["a", "b"], every=every)

    assert stated_ages(made) == [(0, 4 * n)]


@pytest.mark.parametrize(
    ("every", "delay", "least", "most"),
    [
        ({"a": 3}, 0, 0, 2),
        ({"b": 3}, 0, 0, 0),
        ({"a": 2, "b": 3}, 0, 0, 1),
        ({"a": 3}, 2, 2, 4),
        ({"a": 2, "b": 2}, 1, 2, 2),
    ],
)
def test_an_fmu_at_every_nth_tick_makes_an_entry_a_range(every, delay, least, most):
    made = bench({"a": mark(0), "b": mark(1)}, [wire("a.row", "b.u0", delay=delay)], ["a", "b"], every=every)

    assert stated_ages(made) == [(least, most)]
    assert observed_ages(made) == [(least, most)]


def test_a_wire_from_an_fmu_to_itself_is_one_step_old():
    made = bench({"a": mark(1)}, [wire("a.row", "a.u0")], ["a"])

    assert stated_ages(made) == observed_ages(made) == [(1, 1)]


def test_a_loop_sums_its_entries():
    blocks = {"a": integrator(), "b": integrator(), "c": integrator()}
    wires = [wire("a.x", "b.u"), wire("b.x", "c.u", delay=2), wire("c.x", "a.u")]
    [loop] = bench(blocks, wires, ["a", "b", "c"], step_size=0.25).ledger.loops

    assert (loop.path, loop.steps, loop.seconds) == (["a.x", "b.x", "c.x"], 3, 0.75)


def test_every_simple_loop_is_found_once():
    blocks = {"a": mark(2), "b": mark(2), "c": mark(1)}
    wires = [
        wire("a.row", "b.u0"),
        wire("b.row", "a.u0"),
        wire("b.row", "c.u0"),
        wire("c.row", "a.u1"),
        wire("c.row", "b.u1"),
    ]
    ledger = bench(blocks, wires, ["a", "b", "c"]).ledger

    assert sorted("".join(signal[0] for signal in loop.path) for loop in ledger.loops) == ["ab", "abc", "bc"]


def two_ways(influences):
    """Inputs u, v and outputs x, y, each input acting on the outputs that `influences` names."""
    ports = variables(("u", "input"), ("v", "input"), ("x", "output"), ("y", "output"))
    return Block(lambda t, h, v: {}, ports, influences=influences)


def test_a_loop_may_pass_an_fmu_again_by_another_output():
    blocks = {"suite": two_ways({"x": ("u",), "y": ("v",)}), "mass": integrator(), "axis": integrator()}
    wires = [
        wire("suite.x", "mass.u"),
        wire("mass.x", "suite.v"),
        wire("suite.y", "axis.u"),
        wire("axis.x", "suite.u"),
    ]
    [loop] = bench(blocks, wires, ["suite", "mass", "axis"]).ledger.loops

    assert (loop.path, loop.steps) == (["suite.x", "mass.x", "suite.y", "axis.x"], 2)


def test_an_input_that_does_not_act_on_an_output_closes_no_loop():
    blocks = {"suite": two_ways({"x": ("v",), "y": ("u",)}), "mass": integrator()}
    made = bench(blocks, [wire("suite.x", "mass.u"), wire("mass.x", "suite.u")], ["suite", "mass"])

    assert made.ledger.loops == ()


def test_a_system_with_too_many_loops_says_that_not_all_are_listed():
    n = 8
    wires = [wire(f"m{i}.row", f"m{j}.u{i}") for i in range(n) for j in range(n) if i != j]
    made = bench({f"m{i}": mark(n) for i in range(n)}, wires, [[f"m{i}" for i in range(n)]])

    assert not made.ledger.complete
    assert len(made.ledger.loops) == MOST_LOOPS


def test_a_system_without_loops_has_none():
    assert bench({"a": clock(), "b": gain()}, [wire("a.t", "b.u")]).ledger.loops == ()


def declared(**more):
    """An integrator that declares a delay of its input."""
    given = {"kind": "hold", "seconds": "0", "steps": None, "by": None, "cases": {}, "reason": "why"}
    choice = {"items": {"late": 1, "early": 2}, "start": "1"}
    ports = variables(
        ("u", "input"), ("x", "output"), ("choice", "parameter", choice), ("T", "parameter", {"start": "0.5"})
    )
    return Block(lambda t, h, v: {}, ports, delays=(DeclaredDelay(input="u", **(given | more)),))


@pytest.mark.parametrize(
    ("more", "seconds"),
    [
        ({"steps": 0.5}, 0.05),
        ({"steps": -0.5}, -0.05),
        ({"seconds": "0.02"}, 0.02),
        ({"seconds": "T"}, 0.5),
        ({"by": "choice", "cases": {"late": 1.0, "early": 2.0}}, 0.1),
    ],
)
def test_what_the_target_declares_of_itself_is_added(more, seconds):
    made = bench({"a": clock(), "b": declared(**more)}, [wire("a.t", "b.u")], ["b", "a"], step_size=0.1)
    [entry] = made.ledger.entries

    assert [(o.kind, o.seconds, o.reason) for o in entry.own] == [("hold", seconds, "why")]
    assert entry.seconds == pytest.approx(0.1 + seconds, rel=1e-14)


def test_a_declared_delay_counts_in_steps_of_its_own_fmu():
    made = bench(
        {"a": clock(), "b": declared(steps=0.5)}, [wire("a.t", "b.u")], step_size=0.1, every={"b": 4}
    )
    [entry] = made.ledger.entries

    assert entry.own[0].seconds == pytest.approx(0.2, rel=1e-14)


def test_a_declared_delay_of_nothing_is_not_shown():
    [entry] = bench({"a": clock(), "b": declared()}, [wire("a.t", "b.u")]).ledger.entries

    assert entry.own == ()
