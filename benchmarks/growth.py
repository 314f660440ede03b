"""How the cost of our master grows: with FMUs, connections, recorded signals, and with duration in memory."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

from peers import MASTERS, OURS, PROJECT, measure
from systems import Case, docking_loop, ring

FMUS = (5, 10, 20, 50, 100)
SECONDS = (60.0, 3600.0)
MEGABYTE = 2.0**20


def grow(repetitions: int) -> dict:
    """Measure all; us a step by number of FMUs, MB of memory by seconds simulated."""
    ours = next(m for m in MASTERS if m.name == OURS)
    by_fmus = {
        n: statistics.median(measure(ours, ring(n).spec, n)["us_per_step"] for _ in range(repetitions))
        for n in FMUS
    }
    return {"us_per_step_by_fmus": by_fmus, "memory_mb_by_seconds": memory()}


def memory() -> dict[float, float]:
    """Largest resident memory [MB] of a run that streams its results, by simulated seconds."""
    case = docking_loop()
    return {seconds: _peak(case, seconds) for seconds in SECONDS}


def _peak(case: Case, seconds: float) -> float:
    runner = Path(__file__).parent / "runners" / "streamed.py"
    environment = {**os.environ, "PYTHONPATH": str(PROJECT)}
    command = [sys.executable, runner, case.config, str(seconds)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    return json.loads(done.stdout)["peak_bytes"] / MEGABYTE


if __name__ == "__main__":
    print(json.dumps(grow(3)))
