"""
What docs/before_you_switch_on.md claims in numbers: commissioning, the docking after it, pre-flight.

    python benchmarks/rig_owner.py [--seeds 21 22 23] [--only commissioning information told preflight]
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
from master.commissioning.preflight import Plant, preflight
from master.commissioning.rig import run_held
from master.comparison.cells import Cell
from master.comparison.compare import Task, scores
from master.comparison.methods import all_methods
from master.evaluation.modes import poles_of
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request
from master.installation import configuration
from master.stepping.simulate import simulate

E2 = configuration("experiment_1000kg")
HIGHEST = 18.0
OF_FMUS = Knowledge(1e-3, interpolations=2.0, spread=0.01, force_zero=0.0)
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
SIMULATED = 15.0
SETTLED = 0.5
"""Length of a run, and of its beginning that is left out [s]."""
CYCLES = 80.0
"""Cycles of a pole over which it is looked for in a run."""
SYSTEMS = {
    "experiment_1000kg": (),
    "high_frequency": (),
    "experiment": (
        *("spacecraft.m_s=2300", "ideal.m_s=2300", "force_sensor.T_f=0.006"),
        *(f"{name}.k_p=90000" for name in BOTH),
        *(f"{name}.c_p=180" for name in BOTH),
        *("motion_simulator.K_p=22", "motion_simulator.z=0.6"),
    ),
}
"""Systems whose damping is judged, with what is set: the third is a rig that no configuration has."""
CHANGE = 1e-3
"""Share by which a parameter is changed for a difference quotient."""
CHIRPS = (Chirp(), Chirp(amplitude=2e-3), Chirp(amplitude=2e-3, duration=60.0))
SPLIT = 0.01
"""Deviation of ln(k_m/k_p) and of ln(c_m/c_p), as in the fit."""


def main() -> None:
    """Print what is asked for."""
    parts = {
        "commissioning": _commissioning,
        "information": _information,
        "told": _told,
        "preflight": _preflight,
    }
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


def _information(_: list[int]) -> None:
    """
    Least deviation of k from the FMUs alone: (J'J)^-1 over the noise, J the force at every tick by parameter.

    Nothing of the fit is in it: no transfer function, no transform, no transient. Unknown are the logarithms
    of stiffness, of damping and of T_f, the two ratios but for SPLIT, and the zero of the force or not that.
    """
    ways = {
        "k": {"contact.k_m": 1.0, "contact.k_p": 1.0},
        "k_m/k_p": {"contact.k_m": 0.5, "contact.k_p": -0.5},
        "c": {"contact.c_m": 1.0, "contact.c_p": 1.0},
        "c_m/c_p": {"contact.c_m": 0.5, "contact.c_p": -0.5},
        "T_f": {"force_sensor.T_f": 1.0},
    }
    print("| chirp | noise | least deviation of k [%], zero unknown | zero known |")
    for chirp in CHIRPS:
        slopes = [_slope(way, chirp) for way in ways.values()]
        J = np.column_stack([*slopes, np.ones(len(slopes[0]))])
        prior = np.diag([SPLIT**-2.0 if "/" in name else 0.0 for name in [*ways, "zero"]])
        true = beliefs(prepare_to_run(E2))
        share = (true["k_m"] - true["k_p"]) / (true["k_m"] + true["k_p"])
        to_k = np.array([1.0, -0.5 * share, 0.0, 0.0, 0.0, 0.0])
        for sigma in NOISES:
            information = J.T @ J / sigma**2 + prior
            deviations = [np.sqrt(to_k[:n] @ np.linalg.solve(information[:n, :n], to_k[:n])) for n in (6, 5)]
            text = f"{1e3 * chirp.amplitude:g} mm, {chirp.duration:g} s | {sigma:g} N"
            print(f"| {text} |" + "".join(f" {1e2 * one:.4f} |" for one in deviations), flush=True)


def _slope(way: Mapping[str, float], chirp: Chirp) -> np.ndarray:
    """Return the change of the measured force [N] at every tick by that of a logarithm."""
    base = prepare_to_run(E2)
    forces = []
    for sign in (1.0, -1.0):
        values = ["force_sensor.sigma=0"]
        for name, power in way.items():
            instance, _, variable = name.partition(".")
            value = float(base.system.instances[instance].value_of(variable) or 0.0)
            values.append(f"{name}={value * math.exp(sign * CHANGE * power)!r}")
        forces.append(run_held(prepare_to_run(E2, Request(assignments=tuple(values))), chirp).f_mea)
    return (forces[0] - forces[1]) / (2.0 * CHANGE)


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
    for name, changes in SYSTEMS.items():
        for method in all_methods():
            request = Request(assignments=changes)
            [one] = prepared_methods(configuration(name), request, method, silent)
            found = preflight(one.experiment, BOX, method)
            apart = [abs(_simulated(one.experiment, plant) - plant.zeta) for plant in found.plants]
            zetas = [plant.zeta for plant in found.plants]
            print(
                f"| {name} | `{method}` | {min(zetas):.4f} to {max(zetas):.4f} | {max(apart):.1e} |",
                flush=True,
            )


def _simulated(experiment: Experiment, plant: Plant) -> float:
    """Return the damping of the mode of a run that is nearest to the pole of a plant, damped least of all."""
    system, _ = frozen(experiment.system, after_run=False)
    own = own_values(BOX, experiment.system)
    changes = {"force_sensor.sigma": 0.0}
    for name, factor in plant.factors.items():
        changes |= dict(BOX.box[name].changes(factor, own))
    step = experiment.grid.step_size
    grid = replace(experiment.grid, n_ticks=round(SIMULATED / step))
    outcome = simulate(changed(system, changes), experiment.schedule, grid)
    motion = outcome.result["spacecraft.s_des"][round(SETTLED / step) :]
    seen = poles_of(motion[: round(CYCLES / plant.frequency / step)], step)
    frequencies = seen.imag / (2.0 * np.pi)
    nearest = seen[np.argmin(np.abs(frequencies - plant.frequency))]
    return float(-nearest.real / abs(nearest))


if __name__ == "__main__":
    main()
