"""
What docs/before_you_switch_on.md claims in numbers: commissioning, the docking after it, pre-flight.

    python benchmarks/rig_owner.py [--seeds 21 22 23] [--only commissioning told preflight]
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from master.analysis.closed_loop.linearise import changed, frozen
from master.api import prepare_to_run
from master.catalogue import silent
from master.commissioning.beliefs import beliefs
from master.commissioning.box import Box, own_values
from master.commissioning.chirp import Chirp
from master.commissioning.commission import commission
from master.commissioning.methods import prepared_methods
from master.commissioning.models import Knowledge
from master.commissioning.preflight import preflight
from master.commissioning.rig import run_held
from master.comparison.cells import Cell
from master.comparison.compare import Task, scores
from master.comparison.methods import all_methods
from master.evaluation.modes import dominant_mode
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request
from master.installation import configuration
from master.stepping.simulate import simulate

E2 = configuration("experiment_1000kg")
HIGHEST = 18.0
OF_FMUS = Knowledge(1e-3, interpolations=2.0, spread=0.01)
FACTORS = {"k_m": 1.2, "k_p": 1.2, "c_m": 0.7, "c_p": 0.7, "T_f": 0.7, "K_p": 0.83, "w_v": 0.88, "z": 0.88}
"""Beliefs from which the fit starts, in terms of the rig."""
NOISES = (0.03, 0.5, 5.0)
BOTH = ("contact", "ideal")
STIFF = {f"{name}.{k}": value for name in BOTH for k, value in {"k_m": 167040.0, "k_p": 45312.0}.items()}
DAMPED = {f"{name}.{c}": value for name in BOTH for c, value in {"c_m": 95.3, "c_p": 68.1}.items()}
SLOW = {"motion_simulator.K_p": 25.0, "motion_simulator.w_v": 104.72}
RIGS: dict[str, dict[str, float]] = {
    "as believed": {},
    "T_f 7 ms": {"force_sensor.T_f": 0.007},
    "T_f 13 ms": {"force_sensor.T_f": 0.013},
    "c x0.7": DAMPED,
    "k x1.2": STIFF,
    "lag x1.2": SLOW,
    "all wrong, 0.5 N": {**STIFF, **SLOW, "force_sensor.T_f": 0.012, "force_sensor.sigma": 0.5},
}
BOX = Box.model_validate(
    {
        "box": {
            "stiffness": {"multiplies": ["contact.k_m", "contact.k_p"], "from": 0.8, "to": 1.1},
            "lag": {"divides": ["motion_simulator.K_p", "motion_simulator.w_v"], "from": 0.95, "to": 1.05},
        },
        "points": 2,
    }
)
SIMULATED = 15.0  # s


def main() -> None:
    """Print what is asked for."""
    parts = {"commissioning": _commissioning, "told": _told, "preflight": _preflight}
    asked = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    asked.add_argument("--seeds", type=int, nargs="+", default=[21, 22, 23, 24, 25, 26])
    asked.add_argument("--only", nargs="+", choices=parts, default=list(parts))
    given = asked.parse_args()
    for name in given.only:
        parts[name](given.seeds)


def _commissioning(seeds: list[int]) -> None:
    """Errors of the fit from wrong beliefs, the largest in terms of the deviations that it states."""
    experiment = prepare_to_run(E2, Request(assignments=("force_sensor.sigma=0",)))
    record = run_held(experiment, Chirp())
    true = beliefs(experiment)
    true |= _series(true)
    wrong = {**true, **{name: factor * true[name] for name, factor in FACTORS.items()}, "dead_time": 0.003}
    print("| noise | T_f [ms] | c [%] | k [%] | motion simulator [%] | largest in deviations | warnings |")
    for sigma in NOISES:
        rows = []
        for seed in seeds:
            noise = sigma * np.random.default_rng(seed).normal(size=len(record.f_mea))
            found = commission(replace(record, f_mea=record.f_mea + noise), wrong, HIGHEST, OF_FMUS)
            errors = {name: found[name].value - true[name] for name in ("T_f", "c", "k", "K_p", "w_v", "z")}
            of_plant = max(abs(errors[name]) / true[name] for name in ("K_p", "w_v", "z"))
            judged = [abs(errors[name]) / found[name].deviation for name in ("T_f", "c", "k", "K_p")]
            shares = [1e2 * abs(errors[name]) / true[name] for name in ("c", "k")]
            warnings = sum("lacks" in text for text in found.warnings)
            rows.append([1e3 * abs(errors["T_f"]), *shares, 1e2 * of_plant, max(judged), warnings])
        print(f"| {sigma:g} N |" + "".join(f" {value:.3g} |" for value in np.max(rows, axis=0)), flush=True)


def _series(contact: Mapping[str, float]) -> dict[str, float]:
    """Return stiffness and damping of the whole contact."""
    k_m, k_p, c_m, c_p = (contact[name] for name in ("k_m", "k_p", "c_m", "c_p"))
    k = k_m * k_p / (k_m + k_p)
    return {"k": k, "c": k * (c_m / k_m + c_p / k_p - (c_m + c_p) / (k_m + k_p))}


def _told(seeds: list[int]) -> None:
    """NRMSE of `robust` on rigs that are not as believed, after their commissioning."""
    robust = all_methods()["robust"]
    for name, changes in RIGS.items():
        experiment = prepare_to_run(E2, Request(assignments=tuple(f"{k}={v}" for k, v in changes.items())))
        found = commission(run_held(experiment, Chirp()), beliefs(prepare_to_run(E2)), HIGHEST, OF_FMUS)
        told = {key: value for key, value in found.parameters().items() if key in robust.takes()}
        [result] = scores([Task(E2, "told", Cell(set=dict(changes), told=told), robust, tuple(seeds))])
        numbers = "diverged" if result.s_des is None else f"{result.s_des:.2f}/{result.s_act:.2f}"
        print(f"| {name} | {numbers} |", flush=True)


def _preflight(_: list[int]) -> None:
    """Damping of the matrix of a tick against that of a run without noise, in which nothing adapts."""
    for method in all_methods():
        [one] = prepared_methods(E2, Request(), method, silent)
        found = preflight(one.experiment, BOX, method)
        apart = [abs(_simulated(one.experiment, plant.factors) - plant.zeta) for plant in found.plants]
        print(f"| `{method}` | {max(apart):.1e} |", flush=True)


def _simulated(experiment: Experiment, factors: Mapping[str, float]) -> float:
    system, _ = frozen(experiment.system, after_run=False)
    own = own_values(BOX, experiment.system)
    changes = {"force_sensor.sigma": 0.0}
    for name, factor in factors.items():
        changes |= dict(BOX.box[name].changes(factor, own))
    grid = replace(experiment.grid, n_ticks=round(SIMULATED / experiment.grid.step_size))
    outcome = simulate(changed(system, changes), experiment.schedule, grid)
    mode = dominant_mode(outcome.result["spacecraft.s_des"][2000:], grid.step_size)
    return math.nan if mode is None else mode.zeta


if __name__ == "__main__":
    main()
