"""
The same system in every order of stepping: what each order delays, and what that does to the damping.

All 120 orders of the five FMUs in the loop fall into a few classes, which delay the same connections. Each
class is stepped once; Jacobi, and iteration until the connections agree, in addition to them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations

from numpy.linalg import eigvals

from master.analysis.closed_loop.linearise import Linearisation
from master.analysis.closed_loop.tick_matrix import LinearSystem
from master.analysis.measures.poles import Pole, dominant, poles
from master.coupling.ledger import make_ledger, steps_of
from master.coupling.methods.iterated import Iterated
from master.coupling.schedule import Schedule, make_schedule
from master.experiment.experiment import Experiment
from master.reproduce.measures.poles import without_ideal
from master.reproduce.measures.runs import experiment_of

from .cases import EXACT, LINEAR, run_of

MEMBERS = ("compensator", "spacecraft", "motion_simulator", "contact", "force_sensor")
PAPER = "the configurations' order"
_FORCE_PATH = ("spacecraft.s_des", "motion_simulator.s_act", "contact.f_act", "force_sensor.f_mea")


@dataclass(frozen=True)
class Ordered:
    """
    One class of orders.

    `late` names the connections whose value is one step old, `loop_steps` the steps around the force loop,
    `zeta_none` and `zeta_compensated` the damping ratio without and with compensation (None: no oscillating
    pole).
    """

    name: str
    count: int
    late: tuple[str, ...]
    loop_steps: float
    zeta_none: float | None
    zeta_compensated: float | None
    zeta_ideal: float


def compare(case: str = "S1") -> list[Ordered]:
    """Step a case in every class of orders, without compensation and with it, exact parameters."""
    variants = (run_of(case, "none", plant=LINEAR), run_of(case, "cfdc", EXACT, LINEAR))
    experiments = [experiment_of(run) for run in variants]
    loops = [Linearisation(e).coupled() for e in experiments]
    found = []
    for name, count, order in _orders(experiments[0]):
        schedule = make_schedule(experiments[0].system, order, "order")
        found.append(_ordered(name, count, experiments[0], loops, schedule))
    return found


def _orders(experiment: Experiment) -> list[tuple[str, int, list[str | list[str] | Iterated]]]:
    classes: dict[tuple[int, ...], list[tuple[str, ...]]] = {}
    for order in permutations(MEMBERS):
        schedule = make_schedule(experiment.system, [*order, "ideal"], "order")
        ages = tuple(steps_of(schedule, wire)[0] for wire in experiment.system.wires)
        classes.setdefault(ages, []).append(order)
    found: list[tuple[str, int, list[str | list[str] | Iterated]]] = []
    for same in classes.values():
        name = PAPER if MEMBERS in same else ", ".join(same[0])
        found.append((name, len(same), [*(MEMBERS if MEMBERS in same else same[0]), "ideal"]))
    found.append(("Jacobi: all side by side", 1, [list(MEMBERS), "ideal"]))
    found.append(("iterated until all agree", 1, [Iterated(iterate=MEMBERS), "ideal"]))
    return found


def _ordered(
    name: str, count: int, experiment: Experiment, loops: Sequence[LinearSystem], schedule: Schedule
) -> Ordered:
    ledger = make_ledger(experiment.system, schedule, experiment.grid.step_size)
    late = tuple(f"{e.source} -> {e.target}" for e in ledger.entries if e.mean > 0.0)
    force = [loop for loop in ledger.loops if set(_FORCE_PATH) <= set(loop.path)]
    is_iterated = any(isinstance(group, Iterated) for group in schedule.groups)
    signal = None if is_iterated else "spacecraft.s_des"
    stepped = [without_ideal(replace(loop, schedule=schedule)) for loop in loops]
    without, compensated = (dominant(poles(loop, signal)) for loop in stepped)
    ideal = dominant([Pole(complex(z), loops[0].step_size) for z in _ideal(loops[0])])
    assert ideal is not None
    return Ordered(
        name=name,
        count=count,
        late=late,
        loop_steps=min(loop.steps for loop in force),
        zeta_none=None if without is None else without.zeta,
        zeta_compensated=None if compensated is None else compensated.zeta,
        zeta_ideal=ideal.zeta,
    )


def _ideal(coupled: LinearSystem) -> Sequence[complex]:
    return [complex(z) for z in eigvals(coupled.parts["ideal"].system.A) if z.imag > 0.0]
