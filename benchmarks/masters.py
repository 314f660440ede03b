"""
The same native FMUs under this master, its peers, and a bare C loop over the same kernels.

    python benchmarks/masters.py [--json] [--repetitions 5] [--only SYSTEM ...] [--masters MASTER ...]
                                 [--docs]

`--json` prints rows `{system, master, us_per_step, ratio_to_floor, version}` and the spread.
`--docs` writes the table and the plot of `docs/performance.md`.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
from collections.abc import Sequence

import table
from growth import grow
from peers import FLOOR, MASTERS, OURS, Master, measure
from systems import Case, docking_loop, ring

SYSTEMS = {
    "docking_loop": docking_loop,
    "docking_loop_fmi3": lambda: docking_loop("3.0"),
    "docking_loop_robust": lambda: docking_loop(method="robust"),
    "ring_5": lambda: ring(5),
    "ring_20": lambda: ring(20),
    "ring_100": lambda: ring(100),
}
ALONE = ("docking_loop_fmi3", "docking_loop_robust")
"""Under this master and the floor only: the peers have FMI 2.0 alone, and have stepped the paper's loop."""


def main() -> None:
    """Measure and show."""
    arguments = _arguments()
    rows = []
    for name in arguments.only or SYSTEMS:
        masters = [m for m in MASTERS if name not in ALONE or m.name in (FLOOR, OURS)]
        masters = [m for m in masters if not arguments.masters or m.name in (FLOOR, *arguments.masters)]
        rows += compare(SYSTEMS[name](), masters, arguments.repetitions)
    if arguments.docs:
        table.write(rows, grow(arguments.repetitions))
    print(json.dumps(rows) if arguments.json else table.text(rows))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--only", nargs="*", choices=SYSTEMS)
    parser.add_argument("--masters", nargs="*", choices=[m.name for m in MASTERS], metavar="MASTER")
    parser.add_argument("--docs", action="store_true")
    return parser.parse_args()


def compare(case: Case, masters: Sequence[Master], repetitions: int) -> list[dict]:
    """One row a master; the repetitions of all masters take turns, so that a busy minute meets all."""
    n_fmus = len(json.loads(case.spec.read_text(encoding="utf-8"))["fmus"])
    found: dict[str, list[dict]] = {m.name: [] for m in masters}
    for _ in range(repetitions):
        for master in masters:
            if all("problem" not in answer for answer in found[master.name]):
                found[master.name].append(measure(master, case.spec, n_fmus))
                print(".", end="", file=sys.stderr, flush=True)
    floor = statistics.median(a["us_per_step"] for a in found[FLOOR])
    least_floor = min(a["us_per_step"] for a in found[FLOOR])
    return [_row(case.name, name, answers, floor, least_floor) for name, answers in found.items()]


def _row(system: str, master: str, answers: list[dict], floor: float, least_floor: float) -> dict:
    problems = [a["problem"] for a in answers if "problem" in a]
    if problems:
        return {"system": system, "master": master, "us_per_step": None, "ratio_to_floor": None} | {
            "version": None,
            "problem": problems[0],
        }
    times = [a["us_per_step"] for a in answers]
    median = statistics.median(times)
    return {
        "system": system,
        "master": master,
        "us_per_step": median,
        "ratio_to_floor": median / floor,
        "least_ratio": min(times) / least_floor,
        "version": answers[0]["version"],
        "least": min(times),
        "most": max(times),
        "repetitions": len(times),
    }


if __name__ == "__main__":
    main()
