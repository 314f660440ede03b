"""
The bounds of `docs/compensators.md`: what `robust` has, and the best of all others in each place.

    python benchmarks/method_bounds.py [--first-seed 101] [--seeds 5] [--cells benchmarks/other_cells.yaml]
    python benchmarks/method_bounds.py --scores comparison.json

Runs the shipped cells, or those of a file, in the four cases with leapfrog, all methods. `--scores` judges
what `dockloop compare-methods --json` has printed. A cell belongs to a check by its name: a shipped one by
the list below, another one by the text before its colon. Exit status 1 if a bound is not met.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from master.comparison.cells import SHIPPED, read_cells
from master.comparison.compare import Score, check, compare, tasks
from master.comparison.methods import chosen
from master.installation import configuration

CASES = {"low_frequency": "S1", "high_frequency": "S2", "experiment": "E1", "experiment_1000kg": "E2"}
OURS = "robust"
BEHIND = 0.25
"""Points by which the best of the others may be ahead in a cell."""


@dataclass(frozen=True)
class Bound:
    """Largest NRMSE [%] of s_des and of s_act."""

    s_des: float
    s_act: float


@dataclass(frozen=True)
class Check:
    """A row of the table: the shipped cells that it is about, and the bound by case."""

    name: str
    cells: Sequence[str]
    bounds: Mapping[str, Bound]

    def has(self, cell: str) -> bool:
        """Whether a cell belongs to this check."""
        return cell in self.cells or cell.partition(":")[0] == self.name


def _everywhere(s_des: float, s_act: float) -> dict[str, Bound]:
    return dict.fromkeys(CASES.values(), Bound(s_des, s_act))


def _same(**values: float) -> dict[str, Bound]:
    return {case: Bound(value, value) for case, value in values.items()}


CHECKS = (
    Check("nominal", ["nominal"], {**_everywhere(0.05, 0.06), "S2": Bound(0.15, 0.4)}),
    Check(
        "k_p +-20 % at 1 Hz",
        ["k_p varies by 20 % at 1 Hz"],
        {"S2": Bound(0.2, 0.5), "E2": Bound(0.1, 0.1)},
    ),
    Check(
        "lag of the plant x0.8, x1.2",
        ["plant lag x0.8", "plant lag x1.2"],
        {**_everywhere(0.15, 0.4), "S2": Bound(0.15, 1.2)},
    ),
    Check("noise .5 N", ["noise 0.5 N"], _everywhere(0.3, 0.3)),
    Check("noise 5 N", ["noise 5 N"], _same(S1=1.0, S2=0.5, E1=1.2, E2=2.2)),
    Check("k believed x0.8, x1.2", ["k believed x0.8", "k believed x1.2"], _everywhere(0.2, 0.5)),
    Check("T_f +-30 %", ["T_f 7 ms, believed 10", "T_f 13 ms, believed 10"], _same(E1=1.5, E2=3.0)),
    Check(
        "c +-30 %, sensor trusted",
        ["c believed x0.7, sensor trusted", "c believed x1.3, sensor trusted"],
        _everywhere(0.2, 0.5),
    ),
    Check("c +-30 %, in doubt", ["c believed x0.7", "c believed x1.3"], _everywhere(0.2, 0.5)),
    Check("jitter 0 to 2 ms", ["force jitter 0 to 2 ms"], _same(S1=5.0, S2=15.0, E1=5.0, E2=1.2)),
    Check("s_act noise 20 um", ["s_act noise 20 um"], _everywhere(0.4, 0.4)),
    Check("slack beyond 1 mm", ["slack beyond 1 mm"], _same(S1=0.05)),
    Check(
        "rope 30 % softer",
        ["rope 30 % softer beyond 1 mm", "rope 30 % softer beyond 0.5 mm"],
        _same(S1=0.15, S2=0.6, E1=0.15, E2=0.15),
    ),
    Check(
        "all wrong at once",
        ["all wrong at once, slow", "all wrong at once, fast"],
        {"S2": Bound(0.3, 1.2), "E2": Bound(2.5, 2.5)},
    ),
    Check("60 s", ["60 s"], _everywhere(0.3, 0.3)),
)


def main() -> None:
    """Run or read, print the table, and say where the best of the others is ahead."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--seeds", type=int, default=5)
    asked.add_argument("--first-seed", type=int, default=1)
    asked.add_argument("--cells", type=Path, default=SHIPPED)
    asked.add_argument("--methods", default="all")
    asked.add_argument("--processes", type=int, default=2)
    asked.add_argument("--scores", type=Path, nargs="+", help="judge these, run nothing")
    given = asked.parse_args()
    scores = _read(given.scores) if given.scores else _run(given)
    lines = [_line(one, scores) for one in CHECKS if any(one.has(score.cell) for score in scores)]
    print("| check | bound | `robust` | best of the others | met |\n|---|---|---|---|---|")
    print("\n".join(lines))
    ahead = _ahead(scores)
    print("\n".join(ahead) or f"In no cell is the best of the others ahead by more than {BEHIND:g} points.")
    sys.exit(any("**no**" in line for line in lines) or bool(ahead))


def _run(given: argparse.Namespace) -> list[Score]:
    seeds = tuple(range(given.first_seed, given.first_seed + given.seeds))
    paths = [configuration(name) for name in CASES]
    work = tasks(paths, read_cells(given.cells), chosen(given.methods), given.seeds)
    work = [replace(task, seeds=seeds) for task in work]
    check(work)
    return compare(work, lambda _: None, given.processes)


def _read(files: Sequence[Path]) -> list[Score]:
    return [Score(**row) for file in files for row in json.loads(file.read_text(encoding="utf-8"))["cells"]]


def _line(one: Check, scores: Sequence[Score]) -> str:
    """Return a row of the table: the worst of a check's cells by case, for ours and for each other method."""
    bounds = []
    ours = []
    best = []
    met = True
    for config, case in CASES.items():
        of_case = [score for score in scores if score.config == config and one.has(score.cell)]
        if not of_case or case not in one.bounds:
            continue
        bound = one.bounds[case]
        bounds.append(f"{case} {bound.s_des:g}/{bound.s_act:g}")
        worst = {name: _worst(of_case, name) for name in dict.fromkeys(score.method for score in of_case)}
        own = worst.pop(OURS)
        ours.append(f"{case} {own.s_des:.2f}/{own.s_act:.2f}")
        met = met and own.s_des <= bound.s_des and own.s_act <= bound.s_act
        if worst:
            least = Bound(min(w.s_des for w in worst.values()), min(w.s_act for w in worst.values()))
            best.append(f"{case} {least.s_des:.2f}/{least.s_act:.2f}")
    columns = [one.name, *("; ".join(texts) for texts in (bounds, ours, best)), "yes" if met else "**no**"]
    return "| " + " | ".join(columns) + " |"


def _worst(scores: Sequence[Score], method: str) -> Bound:
    own = [score for score in scores if score.method == method]
    return Bound(max(_or_infinite(s.s_des) for s in own), max(_or_infinite(s.s_act) for s in own))


def _or_infinite(value: float | None) -> float:
    return math.inf if value is None else value


def _ahead(scores: Sequence[Score]) -> list[str]:
    """Say in which cells another method has less by more than BEHIND points."""
    found = []
    for place in dict.fromkeys((score.config, score.cell) for score in scores):
        of_place = [score for score in scores if (score.config, score.cell) == place]
        own = _worst(of_place, OURS)
        for what in ("s_des", "s_act"):
            mine = getattr(own, what)
            others = {s.method: _or_infinite(getattr(s, what)) for s in of_place if s.method != OURS}
            if others and mine > min(others.values()) + BEHIND:
                name = min(others, key=lambda method: others[method])
                found.append(f"{CASES[place[0]]}, {place[1]}, {what}: {mine:.2f}, {name} {others[name]:.2f}")
    return found


if __name__ == "__main__":
    main()
