"""Algebraic loops are found from ModelStructure, named, and what the order does to them is said."""

from master.coupling.algebraic import algebraic_loops
from tests.stubs import bench, gain, integrator, wire

RING = [wire("a.y", "b.u"), wire("b.y", "a.u")]


def loops(blocks, order, wires=RING):
    made = bench(blocks, wires, order)
    return algebraic_loops(made.system, made.schedule)


def test_a_ring_of_gains_is_an_algebraic_loop_whose_last_wire_is_old():
    [loop] = loops({"a": gain(), "b": gain()}, ["a", "b"])

    assert loop.signals == ("a.y", "b.u", "b.y", "a.u")
    assert loop.old == (("b.y -> a.u", 1),)
    assert loop.explain() == (
        "a.y -> b.u -> b.y -> a.u -> a.y: not solved within a step, b.y -> a.u is 1 step old"
    )


def test_side_by_side_both_wires_are_old():
    [loop] = loops({"a": gain(), "b": gain()}, [["a", "b"]])

    assert loop.old == (("a.y -> b.u", 1), ("b.y -> a.u", 1))


def test_an_iterated_group_solves_the_loop():
    [loop] = loops({"a": gain(), "b": gain()}, [{"iterate": ["a", "b"]}])

    assert loop.is_solved
    assert loop.explain().endswith("iterated until it closes")


def test_a_state_breaks_the_loop():
    wires = [wire("a.y", "b.u"), wire("b.x", "a.u")]

    assert loops({"a": gain(), "b": integrator()}, ["a", "b"], wires) == []
