"""Closed paths: every one once, whatever the size of the system."""

from itertools import islice, permutations

import pytest

from master.coupling.loops import closed_paths
from tests.stubs import Block, bench, gain, variables, wire


def everything(description, input_name, output_name):
    return True


def paths(blocks, wires):
    made = bench(blocks, wires, [list(blocks)])
    return closed_paths(made.system, everything)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5])
def test_all_simple_cycles_of_a_complete_graph_are_found(n):
    """Each block sends its output to every other one: a cycle is an order of two or more of them."""
    ports = variables(*[(f"u{i}", "input") for i in range(n)], ("y", "output"))
    blocks = {f"b{i}": Block(lambda t, h, v: {}, ports) for i in range(n)}
    wires = [wire(f"b{i}.y", f"b{j}.u{i}") for i in range(n) for j in range(n) if i != j]
    expected = {p for size in range(2, n + 1) for p in permutations(range(n), size) if p[0] == min(p)}
    found = [tuple(int(wires[i]["from"][1]) for i in path) for path in paths(blocks, wires)]

    assert len(found) == len(expected)
    assert {p[p.index(min(p)) :] + p[: p.index(min(p))] for p in found} == expected


def test_two_wires_between_two_signals_are_two_paths():
    blocks = {
        "a": gain(),
        "b": Block(lambda t, h, v: {}, variables(("u", "input"), ("w", "input"), ("y", "output"))),
    }

    assert list(paths(blocks, [wire("a.y", "b.u"), wire("a.y", "b.w"), wire("b.y", "a.u")])) == [
        (0, 2),
        (1, 2),
    ]


def ladder(n):
    """Blocks in a row, each joined to the next by two wires: two to the power of n ways through."""
    ports = variables(("u", "input"), ("w", "input"), ("y", "output"), ("z", "output"))
    blocks = {f"b{i}": Block(lambda t, h, v: {}, ports) for i in range(n)}
    wires = [wire(f"b{i}.{y}", f"b{i + 1}.{u}") for i in range(n - 1) for y, u in (("y", "u"), ("z", "w"))]
    return blocks, wires


def test_a_ladder_without_a_loop_is_seen_through_at_once():
    assert list(paths(*ladder(60))) == []


def test_the_first_loops_of_a_ladder_come_at_once():
    blocks, wires = ladder(40)
    wires.append(wire("b39.y", "b0.u"))

    assert len(list(islice(paths(blocks, wires), 50))) == 50


def test_a_ring_may_be_longer_than_python_recurses():
    n = 1500
    wires = [wire(f"b{i}.y", f"b{(i + 1) % n}.u") for i in range(n)]
    [path] = islice(paths({f"b{i}": gain() for i in range(n)}, wires), 1)

    assert path == tuple(range(n))
