"""Linear blocks, exact for an input that is linear in a step: all error is that of coupling."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import expm

from tests.stubs import Block, variables

Matrix = NDArray[np.float64]


def transition(a: Matrix, b: Matrix, h: float) -> tuple[Matrix, Matrix, Matrix]:
    """Give x(t+h) = phi x + g0 u(t) + g1 u(t+h) for x' = a x + b u with u linear in between."""
    n, m = b.shape
    big = np.zeros((n + 2 * m, n + 2 * m))
    big[:n, :n], big[:n, n : n + m] = a, b
    big[n : n + m, n + m :] = np.eye(m) / h
    e = expm(big * h)
    return e[:n, :n], e[:n, n : n + m] - e[:n, n + m :], e[:n, n + m :]


@dataclass
class Linear:
    """
    x' = a x + b u, y = c x + d u.

    States and inputs are named by `states` and `inputs`; `outputs` gives for each output its rows
    (c, d). The input of the step before is kept as that of the step's begin.
    """

    a: ArrayLike
    b: ArrayLike
    states: Sequence[str]
    inputs: Sequence[str]
    outputs: Mapping[str, tuple[ArrayLike, ArrayLike]] = field(default_factory=dict)
    known: dict[float, tuple[Matrix, Matrix, Matrix]] = field(default_factory=dict)

    def law(self, t: float, h: float, v: dict[str, float]) -> dict[str, float]:
        """Step it, as a law of `stubs`."""
        u, x = np.array([v[name] for name in self.inputs]), np.array([v[name] for name in self.states])
        if h:
            if h not in self.known:
                self.known[h] = transition(np.array(self.a, float), np.array(self.b, float), h)
            phi, g0, g1 = self.known[h]
            x = phi @ x + g0 @ np.array([v[f"old_{name}"] for name in self.inputs]) + g1 @ u
        y = {name: float(np.dot(c, x) + np.dot(d, u)) for name, (c, d) in self.outputs.items()}
        old = {f"old_{name}": v[name] for name in self.inputs}
        return dict(zip(self.states, x.tolist(), strict=True)) | y | old

    def block(self) -> Block:
        """Make a block of which states and outputs are outputs."""
        state = {"initial": "exact"}
        ports: list[Any] = [(name, "input") for name in self.inputs]
        ports += [(name, "output", state) for name in self.states] + [
            (name, "output") for name in self.outputs
        ]
        hidden = [(f"old_{name}", "local") for name in self.inputs]
        through = {
            name: tuple(u for u, gain in zip(self.inputs, np.atleast_1d(d), strict=True) if gain)
            for name, (_, d) in self.outputs.items()
        }
        return Block(self.law, variables(*ports, *hidden), dict.fromkeys(self.states, ()) | through)
