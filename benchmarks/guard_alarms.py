"""
When guards alarm: the paper's cases in all variants, and pairs of cell and method of `compare-methods`.

    python benchmarks/guard_alarms.py [--pairs 114] [--seed 1] [--part 1/2] > runs.jsonl
    python benchmarks/guard_alarms.py --table runs.jsonl

Guards of several settings watch the same run without a hand in it. A run has diverged once its displacement
is beyond 1.5 times the largest one of the ideal docking; its cycles are those of the ideal docking. Whether a
run diverges does not depend on when it was stopped: one that grows and has not got there goes on for LONGER
times its length. The seed draws the pairs and is that of their noise.
"""

from __future__ import annotations

import argparse
import copy
import json
import sys
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binomtest

from master.api import prepare_to_run
from master.comparison.cells import read_cells
from master.comparison.methods import all_methods
from master.comparison.systems import Base, system
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request
from master.installation import configuration
from master.runs.kept_runs import KeptRuns
from master.system.config import Config, LoadedConfig
from master.text.validation import validate
from master.text.yaml_lines import Document

PAPER = ("low_frequency", "high_frequency", "experiment", "experiment_1000kg", "time_varying_stiffness")
COMPARED = PAPER[:4]
NOISES = (0.03, 0.5)
SETTINGS = {
    "0.1, 1": {"tolerance": 0.1, "slow_limit": 1.0},
    "0.05, 1.8": {"tolerance": 0.05, "slow_limit": 1.8},
    "0.1, 1.8": {"tolerance": 0.1, "slow_limit": 1.8},
    "0.3, 1.8": {"tolerance": 0.3, "slow_limit": 1.8},
}
"""Tolerance and slow limit of the guards."""
VARIES = 0.2
DIVERGED = 1.5
GROWN = 1.005
"""Displacement over the largest one of the ideal docking beyond which a run is said to grow."""
LONGER = 5.0


@dataclass(frozen=True)
class Watched:
    """A system with guards that watch."""

    name: str
    base: Base
    document: dict[str, Any]
    request: Request


def main() -> None:
    """Make the runs, or print the table of runs that were made."""
    asked = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    asked.add_argument("--pairs", type=int, default=114)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--only-pairs", action="store_true", help="without the paper's cases")
    asked.add_argument("--part", default="1/1", help="which part of how many")
    asked.add_argument("--table", type=Path, nargs="+", help="files of runs")
    given = asked.parse_args()
    if given.table:
        rows = [json.loads(line) for file in given.table for line in file.read_text().splitlines()]
        print("\n".join(_table(rows)))
        return
    part, parts = map(int, given.part.split("/"))
    with closing(KeptRuns()) as runs:
        of_the_paper = [] if given.only_pairs else _of_the_paper()
        for i, one in enumerate([*of_the_paper, *_pairs(given.pairs, given.seed)]):
            if i % parts == part - 1:
                print(json.dumps(_run(runs, one)), flush=True)
                print(one.name, file=sys.stderr, flush=True)


def _of_the_paper() -> Iterator[Watched]:
    for name in PAPER:
        base = Base(configuration(name))
        document = _guarded(base.document, base, VARIES if name == "time_varying_stiffness" else 0.0)
        for variant in base.document["variants"]:
            for sigma in NOISES:
                request = Request(variant=variant, assignments=(f"{base.sensor}.sigma={sigma}",))
                yield Watched(f"{name}, {variant}, {sigma:g} N", base, document, request)


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
        document = _guarded(system(base, cells[cell], method, seed), base, VARIES if varies else 0.0)
        yield Watched(f"{base.name}, {cell}, {method.name}", base, document, Request())


def _guarded(document: dict[str, Any], base: Base, variation: float) -> dict[str, Any]:
    made = copy.deepcopy(document)
    contact = next(wire["from"] for wire in made["connections"] if wire["to"] == f"{base.compensator}.x")
    sources = {
        "s_des": f"{base.spacecraft}.s_des",
        "v_des": f"{base.spacecraft}.v_des",
        "s_act": f"{base.plant}.s_act",
        "f_mea": f"{base.sensor}.f_mea",
        "x": contact,
    }
    for i, setting in enumerate(SETTINGS.values()):
        values = {**setting, "m_s": base.value(base.spacecraft, "m_s"), "variation": variation}
        made["fmus"][f"guard_{i}"] = {"source": "guard", "parameters": values}
        made["coupling"]["order"].append(f"guard_{i}")
        made["connections"] += [{"from": source, "to": f"guard_{i}.{to}"} for to, source in sources.items()]
    return made


def _run(runs: KeptRuns, one: Watched) -> dict[str, Any]:
    found = validate(Config, Document(one.base.path, one.document), "system")
    assert found.model is not None, found.problems
    loaded = LoadedConfig(found.model, found.document, found.problems)
    judged = one.document["compare"]
    row = _watched(runs, prepare_to_run(loaded, one.request), judged)
    if row["beyond"] is None and row["largest"] > GROWN:
        stop_time = LONGER * float(one.document["stop_time"])
        later = _watched(runs, prepare_to_run(loaded, replace(one.request, stop_time=stop_time)), judged)
        row = {**later, "largest_at_stop": row["largest"]}
    return {"run": one.name, **row}


def _watched(runs: KeptRuns, experiment: Experiment, judged: dict[str, str]) -> dict[str, Any]:
    result = runs.run(experiment).result
    motion, ideal = (np.asarray(result[judged[key]]) for key in ("signal", "reference"))
    ratio = np.abs(motion) / np.max(np.abs(ideal))
    crossings = np.count_nonzero(np.diff(np.sign(ideal)))
    ticks = 2.0 * len(ideal) / crossings
    alarms = {name: _first(result[f"guard_{i}.alarm"] > 0.5) for i, name in enumerate(SETTINGS)}
    beyond = _first(ratio > DIVERGED)
    return {
        "largest": float(np.max(ratio)),
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
        caught = [r["alarms"][name] for r in diverging if r not in missed]
        false = [r for r in others if r["alarms"][name] is not None]
        grow = sum(r["largest"] > GROWN for r in false)
        median, most = np.quantile(caught, (0.5, 0.9)) if caught else (np.nan, np.nan)
        numbers = (
            f"{len(diverging)} | {len(caught)} | {median:.2f}, {most:.2f} | {len(false)} of {len(others)}"
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
