"""
When guards alarm: the paper's cases in all variants, and pairs of cell and method of `compare-methods`.

    python benchmarks/guard_alarms.py [--pairs 300] [--seed 1] [--part 1/2] > runs.jsonl
    python benchmarks/guard_alarms.py --paper 20 > runs.jsonl
    python benchmarks/guard_alarms.py --table runs.jsonl

Guards of several settings watch the same run without a hand in it; noise of the force and variation of the
stiffness are declared to them, and to the first one how late a cell lets motion and force be: at w a lateness
tau makes the energy grow by exp(pi w tau/2) up to the first peak of speed, which its tolerance covers. A run
has diverged once its displacement is beyond 1.5 times the largest one of the ideal docking; its cycles are
those of the ideal docking. Whether a run diverges does not depend on when it was stopped: one that has grown
goes on for LONGER times its length, and again as long as it is at its largest at the end. The seed draws the
pairs and is that of their noise; --pairs 2000 takes all there are. --paper: every variant of the paper's
cases with as many seeds, 20 s. Columns: diverging, caught before, median cycles to the alarm of those that
diverge before their stop time and of all, alarms in the others, their share, those of them without growth.
"""

from __future__ import annotations

import argparse
import copy
import json
import math
import sys
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binomtest

from master.api import prepare_to_run
from master.comparison.cells import Cell, read_cells
from master.comparison.methods import all_methods
from master.comparison.systems import Base, system
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request
from master.installation import configuration
from master.runs.kept_runs import KeptRuns
from master.system.config import Config, LoadedConfig
from master.text.validation import validate
from master.text.yaml_lines import Document

COMPARED = ("low_frequency", "high_frequency", "experiment", "experiment_1000kg")
PAPER = (*COMPARED, "drag", "time_varying_stiffness")
OF_PAPER = 20.0
"""Length of a run of the paper's cases [s]."""
NOISES = (0.03, 0.5)
DECLARED = "as declared"
LEAST_TOLERANCE = 0.05
SETTINGS: dict[str, dict[str, float]] = {
    DECLARED: {},
    "0.05": {"tolerance": 0.05},
    "0.1": {"tolerance": 0.1},
    "0.05, every gain": {"tolerance": 0.05, "start_share": 0.0},
    "0.05, at once": {"tolerance": 0.05, "start_share": 0.0, "slow_limit": 1.0},
}
"""Guards; DECLARED: tolerance by the cell; `every gain`: start_share 0; `at once`: slow_limit 1, too."""
VARIES = 0.2
DIVERGED = 1.5
GROWN = 1.005
"""Displacement over the largest one of the ideal docking beyond which a run is said to grow."""
LONGER = 5.0
LONGEST = 1500.0
"""Length of a run [s] after which it is judged as it is."""
AT_ITS_END = 0.9
"""Share of a run after which its largest displacement lies where it still grows."""


@dataclass(frozen=True)
class Watched:
    """A system with guards that watch."""

    name: str
    base: Base
    document: dict[str, Any]
    request: Request
    declared: dict[str, float]


def main() -> None:
    """Make the runs, or print the table of runs that were made."""
    asked = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    asked.add_argument("--pairs", type=int, default=300)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--paper", type=int, metavar="SEEDS", help="the paper's cases instead of pairs")
    asked.add_argument(
        "--tolerances", type=float, nargs="+", help="guards of these instead of the usual ones"
    )
    asked.add_argument("--part", default="1/1", help="which part of how many")
    asked.add_argument("--table", type=Path, nargs="+", help="files of runs")
    given = asked.parse_args()
    if given.table:
        rows = [json.loads(line) for file in given.table for line in file.read_text().splitlines()]
        print("\n".join(_table(rows)))
        return
    tolerances = {f"{value:g}": {"tolerance": value} for value in given.tolerances or []}
    settings = tolerances or SETTINGS
    part, parts = map(int, given.part.split("/"))
    with closing(KeptRuns()) as runs:
        of_the_paper = given.paper is not None
        for i, one in enumerate(
            _of_the_paper(given.paper) if of_the_paper else _pairs(given.pairs, given.seed)
        ):
            if i % parts == part - 1:
                print(json.dumps(_run(runs, one, settings)), flush=True)
                print(one.name, file=sys.stderr, flush=True)


def _of_the_paper(n_seeds: int) -> Iterator[Watched]:
    for name in PAPER:
        base = Base(configuration(name))
        for variant in base.document["variants"]:
            for sigma in NOISES:
                declared = {"force_noise": sigma, "variation": VARIES if name == PAPER[-1] else 0.0}
                declared["tolerance"] = LEAST_TOLERANCE
                for seed in range(1, n_seeds + 1):
                    values = {"sigma": sigma, "seed": seed}
                    assignments = tuple(f"{base.sensor}.{key}={value}" for key, value in values.items())
                    request = Request(variant=variant, assignments=assignments, stop_time=OF_PAPER)
                    yield Watched(f"{name}, {variant}, {sigma:g} N", base, base.document, request, declared)


def _pairs(n: int, seed: int) -> Iterator[Watched]:
    """Draw pairs; `slack` lets the spacecraft go, so that nothing swings."""
    cells = {name: cell for name, cell in read_cells().items() if not name.startswith("slack")}
    all_pairs = [
        (base, cell, method)
        for base in (Base(configuration(name)) for name in COMPARED)
        for method in all_methods().values()
        for cell in cells
        if cells[cell].configs is None or base.name in (cells[cell].configs or [])
    ]
    drawn = np.random.default_rng(seed).choice(len(all_pairs), size=min(n, len(all_pairs)), replace=False)
    for base, cell, method in (all_pairs[i] for i in sorted(drawn)):
        varies = any(signal.endswith("_amplitude") for signal in cells[cell].set)
        compared = system(base, cells[cell], method, seed)
        sigma = compared["fmus"][base.sensor]["parameters"]["sigma"]
        declared = {"force_noise": sigma, "variation": VARIES if varies else 0.0}
        declared["tolerance"] = _tolerance(base, cells[cell], compared)
        yield Watched(f"{base.name}, {cell}, {method.name}", base, compared, Request(), declared)


def _tolerance(base: Base, cell: Cell, document: dict[str, Any]) -> float:
    """Return what a rig that is late or early gains up to its first peak of speed, and LEAST_TOLERANCE."""
    believed = base.beliefs(cell)
    fmus = document["fmus"]
    plant = fmus[base.plant].get("parameters") or {}
    sensor = fmus[base.sensor]["parameters"]
    lag = 1.0 / float(plant.get("K_p", base.value(base.plant, "K_p")))
    off = abs(lag - 1.0 / believed["K_p"]) + abs(float(sensor["T_f"]) - believed["T_f_hat"])
    steps = [sum(map(float, event["jitter"].values())) for event in cell.events if "jitter" in event]
    off += 0.5 * sum(steps) * float(document["step_size"])
    w = math.sqrt(believed["stiffness"] / believed["m_s"])
    return (1.0 + LEAST_TOLERANCE) * math.exp(0.5 * math.pi * w * off) - 1.0


def _guarded(one: Watched, settings: dict[str, dict[str, float]]) -> dict[str, Any]:
    made = copy.deepcopy(one.document)
    base = one.base
    travel = next(wire["from"] for wire in made["connections"] if wire["to"] == f"{base.compensator}.x")
    sources = {
        "s_des": f"{base.spacecraft}.s_des",
        "v_des": f"{base.spacecraft}.v_des",
        "s_act": f"{base.plant}.s_act",
        "f_mea": f"{base.sensor}.f_mea",
        "x": travel,
    }
    drag = (made["fmus"][travel.partition(".")[0]].get("start") or {}).get("v", 0.0)
    for i, setting in enumerate(settings.values()):
        values = {**one.declared, **setting, "m_s": base.value(base.spacecraft, "m_s")}
        made["fmus"][f"guard_{i}"] = {"source": "guard", "parameters": values, "start": {"v": drag}}
        made["coupling"]["order"].append(f"guard_{i}")
        made["connections"] += [{"from": source, "to": f"guard_{i}.{to}"} for to, source in sources.items()]
    return made


def _run(runs: KeptRuns, one: Watched, settings: dict[str, dict[str, float]]) -> dict[str, Any]:
    found = validate(Config, Document(one.base.path, _guarded(one, settings)), "system")
    assert found.model is not None, found.problems
    loaded = LoadedConfig(found.model, found.document, found.problems)
    wanted = one.document["compare"], list(settings)
    row = _watched(runs, prepare_to_run(loaded, one.request), *wanted)
    at_stop = row["largest"]
    has_grown = at_stop > GROWN
    stop_time = LONGER * float(one.request.stop_time or one.document["stop_time"])
    while row["beyond"] is None and has_grown and stop_time <= LONGEST:
        row = _watched(runs, prepare_to_run(loaded, replace(one.request, stop_time=stop_time)), *wanted)
        row["largest_at_stop"] = at_stop
        has_grown = row["grows"]
        stop_time *= LONGER
    return {"run": one.name, **row}


def _watched(
    runs: KeptRuns, experiment: Experiment, judged: dict[str, str], guards: list[str]
) -> dict[str, Any]:
    result = runs.run(experiment).result
    motion, ideal = (np.asarray(result[judged[key]]) for key in ("signal", "reference"))
    ratio = np.abs(motion) / np.max(np.abs(ideal))
    crossings = np.count_nonzero(np.diff(np.sign(ideal)))
    ticks = 2.0 * len(ideal) / crossings
    alarms = {name: _first(result[f"guard_{i}.alarm"] > 0.5) for i, name in enumerate(guards)}
    beyond = _first(ratio > DIVERGED)
    return {
        "largest": float(np.max(ratio)),
        "grows": bool(np.argmax(ratio) > AT_ITS_END * len(ratio)),
        "beyond": None if beyond is None else beyond / ticks,
        "alarms": {name: None if k is None else k / ticks for name, k in alarms.items()},
    }


def _first(is_so: np.ndarray) -> int | None:
    return int(np.argmax(is_so)) if is_so.any() else None


def _table(rows: list[dict[str, Any]]) -> list[str]:
    diverging = [row for row in rows if row["beyond"] is not None]
    others = [row for row in rows if row["beyond"] is None]
    later = sum("largest_at_stop" in row for row in diverging)
    lines = [f"{len(rows)} runs; {later} of {len(diverging)} that diverge do so after their stop time"]
    for name in rows[0]["alarms"]:
        missed = [r for r in diverging if r["alarms"][name] is None or r["alarms"][name] >= r["beyond"]]
        caught = [r for r in diverging if r not in missed]
        false = [r for r in others if r["alarms"][name] is not None]
        grow = sum(r["largest"] > GROWN for r in false)
        in_time = [r["alarms"][name] for r in caught if "largest_at_stop" not in r]
        median = np.median([r["alarms"][name] for r in caught]) if caught else np.nan
        numbers = (
            f"{len(diverging)} | {len(caught)} | {np.median(in_time):.2f}, {median:.2f} | "
            f"{len(false)} of {len(others)}"
        )
        lines.append(f"| {name} | {numbers} | {_share(len(false), len(others))} | {len(false) - grow} |")
        lines += [f"  alarm: {r['run']}, {r['largest']:.3f}" for r in false]
        lines += [f"  missed: {r['run']}" for r in missed]
    return lines


def _share(n: int, of: int) -> str:
    """Return a share in percent with its exact 95 % interval."""
    interval = binomtest(n, of).proportion_ci()
    return f"{1e2 * n / of:.2f} % ({1e2 * interval.low:.2f} to {1e2 * interval.high:.2f})"


if __name__ == "__main__":
    main()
