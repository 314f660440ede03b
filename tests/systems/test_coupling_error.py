"""
Coupling error of the paper's loop against its monolithic solution, by the order in which it falls with h.

Twice: with subsystems that are exact for straight-line inputs, so that all error is that of coupling,
and with the project's FMUs, whose spacecraft and motion simulator hold an input over a step. An order is
fitted over halved steps; what is left of the next order at the finer ones bends it by less than 0.1.
"""

from __future__ import annotations

import numpy as np
import pytest
import yaml

from master.api import prepare_to_run
from master.stepping.simulate import simulate
from tests.stubs import bench
from tests.systems import paper_loop as loop

END = 0.4
ORDER_OF_EXTRAPOLATION = {0: 1.0, 1: 2.0, 2: 2.0}


def deviation(result, step):
    """Difference of s_des and s_act from the monolithic solution [m], shape (rows, 2)."""
    exact = loop.orbit(loop.WHOLE, loop.START, step, len(result.time) - 1)
    return np.column_stack([result[name] - exact[:, place] for name, place in loop.SHOWN.items()])


def slope(error, steps):
    """Order fitted to the largest deviations at steps of h [s]."""
    return np.polyfit(np.log(steps), np.log([error(h) for h in steps]), 1)[0]


def of_exact_blocks(name, extrapolation, step):
    order = loop.ORDERS[name]
    wires = loop.connections(order, extrapolation)
    made = bench(loop.exact_blocks(), wires, order, step_size=step, start=loop.EXACT_START)
    outcome = made.run(round(END / step))
    assert outcome.status == "completed"
    return np.abs(deviation(outcome.result, step)).max() / abs(loop.s0)


def coupled_fmus(folder, name, extrapolation, step, integrator="semi_implicit"):
    order = loop.ORDERS[name]
    given = {"name": "paper_loop", "step_size": step, "stop_time": END, "fmus": loop.fmus(step, integrator)}
    given |= {"connections": loop.connections(order, extrapolation), "coupling": {"order": order}}
    file = folder / f"{step:g}.yaml"
    file.write_text(yaml.safe_dump(given))
    return prepare_to_run(file)


def of_fmus(experiment):
    outcome = simulate(experiment.system, experiment.schedule, experiment.grid)
    assert outcome.status == "completed"
    return deviation(outcome.result, experiment.config.step_size)


@pytest.mark.parametrize(("name", "extrapolation"), loop.SCHEMES)
def test_exactly_solved_subsystems_fall_with_the_order_of_the_scheme(name, extrapolation):
    expected = 2.0 if name == "iterated" else ORDER_OF_EXTRAPOLATION[extrapolation]
    found = slope(lambda h: of_exact_blocks(name, extrapolation, h), (2e-3, 1e-3))

    assert found == pytest.approx(expected, abs=0.1)


def test_the_error_of_held_values_grows_with_the_number_of_steps_that_they_are_old():
    """One wire of the four of the loop is old in a sequence, three against it, four side by side."""
    errors = [of_exact_blocks(n, 0, 1e-3) for n in ("from spacecraft", "against the loop", "side by side")]

    assert np.array(errors) / errors[0] == pytest.approx([1.0, 3.0, 4.0], rel=0.02)


@pytest.mark.parametrize(("name", "extrapolation"), loop.SCHEMES)
def test_the_projects_fmus_fall_with_the_first_power_of_the_step(name, extrapolation, tmp_path):
    def error(step):
        return np.abs(of_fmus(coupled_fmus(tmp_path, name, extrapolation, step))).max()

    assert slope(error, (2e-3, 1e-3)) == pytest.approx(1.0, abs=0.1)


# velocity [m/s] over h f0/m_s that the first step of an integrator has at the start: v is half a step off
START_OF = {"semi_implicit": 0.5, "zero_order_hold": 0.0, "explicit_euler": -0.5, "leapfrog": 0.0}


def predicted(experiment, integrator):
    """Error to first order in h [m]: each wire late by what the ledger says, and the integrator's start."""
    step = experiment.config.step_size
    late = np.zeros((8, 8))
    for entry in experiment.ledger.entries:
        lag = sum(o.seconds for o in entry.own if o.kind == "lag")  # of Eq. 4, in the solution already
        late += (entry.seconds - lag) * loop.matrix(loop.WIRES[entry.source, entry.target])
    # x' = A x, z' = A z - sum of delay B C x'
    both = np.block([[loop.WHOLE, np.zeros((8, 8))], [-late @ loop.WHOLE, loop.WHOLE]])
    start = np.concatenate([loop.START, np.zeros(8)])
    start[8 + loop.V_DES] = START_OF[integrator] * step * loop.f0 / loop.m_s
    return loop.orbit(both, start, step, experiment.grid.n_ticks)[:, [8 + loop.S_DES, 8 + loop.S_ACT]]


CASES = [(*scheme, "semi_implicit") for scheme in loop.SCHEMES] + [
    (name, 0, integrator)
    for name in loop.ORDERS
    for integrator in ("zero_order_hold", "explicit_euler", "leapfrog")
]


@pytest.mark.parametrize(("name", "extrapolation", "integrator"), CASES)
def test_the_ledger_predicts_the_error_of_the_projects_fmus(name, extrapolation, integrator, tmp_path):
    experiment = coupled_fmus(tmp_path, name, extrapolation, 1e-3, integrator)
    found, expected = of_fmus(experiment), predicted(experiment, integrator)

    # what is left falls with h^2: up to 4 ticks of 1 ms on a contact of 48 rad/s, (0.1 / 0.2 s) of the error
    assert np.abs(found - expected).max() < 0.03 * np.abs(expected).max()
