"""What holds for each coupling method: the ledger is what a mark shows, the matrix of a tick is the tick."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from master.analysis.closed_loop.tick_matrix import LinearPart, LinearSystem
from master.analysis.state_space import StateSpace
from master.coupling.methods.catalogue import METHODS
from tests.master.coupling.random_systems import random_linear, random_marks

PROJECT = Path(__file__).parents[3]
TRANSIENT, TICKS = 36, 84
ALL = ("side_by_side", *METHODS)


def observed_ages(made):
    """Least and most age in rows that each target saw: its own row less the row of what it received."""
    result = made.run(TICKS).result
    found = []
    for joined in made.system.wires:
        target, port = joined.target.instance, joined.target.variable.name
        rows = np.arange(TICKS + 1)
        stepped = rows[(rows % made.schedule.every[target] == 0) & (rows >= TRANSIENT)]
        ages = stepped - result[f"{target}.{port.replace('u', 'seen')}"][stepped]
        found.append((ages.min(), ages.max()))
    return found


@pytest.mark.parametrize("document", ["configs/README.md", "docs/coupling.md"])
def test_each_method_that_is_found_is_in_the_documents(document):
    text = (PROJECT / document).read_text(encoding="utf-8")

    assert [key for key in METHODS if f"{{{key}: [" not in text] == []


@pytest.mark.parametrize("method", ALL)
@pytest.mark.parametrize("seed", range(40))
def test_the_ledger_of_each_method_equals_a_mark_sent_through(method, seed):
    made = random_marks(method, seed)

    assert [(e.least, e.most) for e in made.ledger.entries] == observed_ages(made)


@pytest.mark.long
@pytest.mark.parametrize("method", ALL)
@pytest.mark.parametrize("seed", range(40, 600))
def test_the_ledger_of_each_method_equals_a_mark_sent_through_600_systems(method, seed):
    made = random_marks(method, seed)

    assert [(e.least, e.most) for e in made.ledger.entries] == observed_ages(made)


@pytest.mark.parametrize("method", ALL)
@pytest.mark.parametrize("seed", range(30))
def test_the_tick_matrix_of_each_method_carries_a_random_linear_system_as_it_is_stepped(method, seed):
    """Rows of the simulation, a period apart, follow the characteristic polynomial of the matrix."""
    made, matrices = random_linear(method, seed)
    parts = {
        name: LinearPart(
            StateSpace(*m, X0=np.zeros((len(m[0]), 0)), misfit=0.0),
            tuple(f"{name}.u{i}" for i in range(m[1].shape[1])),
            tuple(f"{name}.y{i}" for i in range(len(m[2]))),
        )
        for name, m in matrices.items()
    }
    coupled = LinearSystem(made.system, made.schedule, parts, 1.0, {})
    tick = coupled.matrix()
    period = coupled.period
    assert period == math.lcm(*made.schedule.every.values())
    n = len(tick)
    result = made.run(period * (2 * n + 2), compiled=True).result
    samples = result.values[::period]
    characteristic = np.poly(tick)

    scale = np.abs(samples).max()
    assert scale > 1e-3
    for k in range(n, len(samples)):
        left = sum(characteristic[i] * samples[k - i] for i in range(n + 1))
        size = sum(abs(characteristic[i]) * np.abs(samples[k - i]).max() for i in range(n + 1))
        np.testing.assert_allclose(left, 0.0, atol=1e-9 * max(size, scale))
