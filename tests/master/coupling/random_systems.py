"""Random systems of marks and of linear blocks, coupled by each method."""

from __future__ import annotations

import random

import numpy as np

from tests.stubs import Block, bench, mark, variables, wire

WINDOWS = (1, 2, 3, 4)


def group_of(method, members, choose):
    """An entry of `coupling.order`, written as in YAML."""
    if method == "side_by_side":
        return list(members)
    if method == "iterate":
        return {"iterate": list(members), "tolerance": 1e-13, "maximum": 500}
    return {
        "waveform": list(members),
        "window": choose.choice(WINDOWS),
        "sweep": choose.choice(("gauss_seidel", "jacobi")),
        "tolerance": 1e-13,
        "maximum": 2000,
    }


def random_order(method, names, choose):
    """Groups of one method among single FMUs; rates that the method allows."""
    order, every = [], {}
    shuffled = choose.sample(names, len(names))
    while shuffled:
        members = [shuffled.pop() for _ in range(min(len(shuffled), choose.choice((1, 1, 2, 3))))]
        rate = choose.choice((1, 1, 2, 3))
        if choose.random() < 0.5:
            order.append(group_of(method, members, choose))
            each = {n: choose.choice((1, 1, 2, 3)) for n in members}
            every |= {
                "side_by_side": each,
                "iterate": dict.fromkeys(members, rate),
                "waveform": dict.fromkeys(members, 1),
            }[method]
        else:
            order += members
            every |= {name: choose.choice((1, 1, 2, 3)) for name in members}
    return order, every


def random_marks(method, seed):
    """Two to nine marks."""
    choose = random.Random(f"{method} {seed}")
    names = [f"m{i}" for i in range(choose.randint(2, 9))]
    order, every = random_order(method, names, choose)
    inputs = {name: choose.randint(0, 3) for name in names}
    wires = [
        wire(f"{choose.choice(names)}.row", f"{name}.u{i}", delay=choose.choice((0, 0, 1, 2, 5)))
        for name in names
        for i in range(inputs[name])
    ]
    return bench({n: mark(inputs[n]) for n in names}, wires, order, every=every)


def linear(a, b, c, d):
    """x+ = A x + B u, y = C x + D u in a step; every state is a start value x0, x1, ..."""
    n, m, p = len(a), b.shape[1], len(c)

    def law(t, h, v):
        x = np.array([v[f"x{i}"] for i in range(n)])
        u = np.array([v[f"u{i}"] for i in range(m)])
        if not h:
            return {f"y{i}": value for i, value in enumerate(c @ x)}
        new = {f"x{i}": value for i, value in enumerate(a @ x + b @ u)}
        return new | {f"y{i}": value for i, value in enumerate(c @ x + d @ u)}

    ports = [(f"u{i}", "input") for i in range(m)] + [(f"y{i}", "output") for i in range(p)]
    states = [(f"x{i}", "local", {"initial": "exact"}) for i in range(n)]
    return Block(law, variables(*ports, *states))


def random_linear(method, seed):
    """
    Two to four linear blocks of one or two states; loop gains small enough that an iteration converges.

    Returns:
        The bench, and for each block (A, B, C, D).
    """
    choose, numbers = random.Random(f"linear {method} {seed}"), np.random.default_rng(seed)
    names = [f"b{i}" for i in range(choose.randint(2, 4))]
    order, every = random_order(method, names, choose)
    matrices = {}
    for name in names:
        n, m, p = choose.randint(1, 2), choose.randint(1, 2), choose.randint(1, 2)
        a = numbers.normal(size=(n, n))
        a *= 0.9 / max(abs(np.linalg.eigvals(a)))
        b, c = numbers.normal(size=(n, m)), 0.3 * numbers.normal(size=(p, n))
        matrices[name] = (a, b, c, 0.2 * numbers.normal(size=(p, m)))
    wires = []
    for name in names:
        for i in range(matrices[name][1].shape[1]):
            source = choose.choice(names)
            output = choose.randrange(len(matrices[source][2]))
            delay = choose.choice((0, 0, 0, 1, 2))
            wires.append(wire(f"{source}.y{output}", f"{name}.u{i}", delay=delay))
    start = {
        name: {f"x{i}": float(numbers.normal()) for i in range(len(m[0]))} for name, m in matrices.items()
    }
    blocks = {name: linear(*m) for name, m in matrices.items()}
    return bench(blocks, wires, order, every=every, start=start), matrices
