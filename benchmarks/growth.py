"""How the cost of our master grows: with FMUs, connections, recorded signals, and with duration."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

from peers import MASTERS, OURS, PROJECT, measure
from ring_model import Link
from systems import Case, docking_loop, ring

FMUS = (5, 10, 20, 50, 100)
FEW = 5  # FMUs where connections or signals grow
INPUTS = (1, 4, 16, 64)
MORE_OUTPUTS = (0, 8, 32, 128)
SECONDS = (60.0, 3600.0)
MEGABYTE = 2.0**20


def grow(repetitions: int) -> dict:
    """
    Measure all: us a step by number of FMUs, connections and recorded signals.

    By seconds simulated, with the results streamed: us a step and the largest resident memory [MB].
    """
    connections = {FEW * n: ring(FEW, Link(n_inputs=n)) for n in INPUTS}
    signals = {FEW * (2 + n): ring(FEW, Link(n_more=n)) for n in MORE_OUTPUTS}
    return {
        "us_per_step_by_fmus": {n: _time(ring(n), n, repetitions) for n in FMUS},
        "us_per_step_by_connections": {n: _time(c, FEW, repetitions) for n, c in connections.items()},
        "us_per_step_by_signals": {n: _time(c, FEW, repetitions) for n, c in signals.items()},
        "streamed_by_seconds": {seconds: _streamed(docking_loop(), seconds) for seconds in SECONDS},
    }


def _time(case: Case, n_fmus: int, repetitions: int) -> float:
    ours = next(m for m in MASTERS if m.name == OURS)
    return statistics.median(measure(ours, case.spec, n_fmus)["us_per_step"] for _ in range(repetitions))


def _streamed(case: Case, seconds: float) -> dict[str, float]:
    runner = Path(__file__).parent / "runners" / "streamed.py"
    environment = {**os.environ, "PYTHONPATH": str(PROJECT)}
    command = [sys.executable, runner, case.config, str(seconds)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    answer = json.loads(done.stdout)
    return {"us_per_step": answer["us_per_step"], "memory_mb": answer["peak_bytes"] / MEGABYTE}


if __name__ == "__main__":
    print(json.dumps(grow(3)))
