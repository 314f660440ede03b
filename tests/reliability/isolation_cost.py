"""
What it costs to step FMUs in processes of their own.

    python -m tests.reliability.isolation_cost [CHUNKS]

The same systems in process and isolated: the fastest chunk of 200 steps of each, so that what else the
machine does counts as little as may be.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from pathlib import Path

from master.api import prepare_to_run
from master.experiment.prepare import Request
from master.process.child import done_apart
from master.stepping.opened import OpenRun
from master.stepping.outcome import RunOptions
from tests.foreign import faulty

STEPS = 200


def system(n: int, version: int, steps: int) -> str:
    """Return a chain of n FMUs."""
    fmus = "".join(f"  f{i}: {{source: faulty{version}.fmu}}\n" for i in range(n))
    order = ", ".join(f"f{i}" for i in range(n))
    wires = "".join(f"  - {{from: f{i}.x, to: f{i + 1}.input}}\n" for i in range(n - 1))
    head = f"name: chain\nstep_size: 0.001\nstop_time: {steps / 1000}\nfmus:\n"
    return f"{head}{fmus}coupling: {{order: [{order}]}}\n" + (f"connections:\n{wires}" if wires else "")


def seconds(file: Path, isolate: tuple[str, ...], chunks: int) -> float:
    """Return the time of the stepping loop for the fastest chunk [s]."""
    experiment = prepare_to_run(file, Request(isolate=isolate))
    run = OpenRun(experiment.system, experiment.schedule, experiment.grid, RunOptions())
    times = []
    for _ in range(chunks):
        before = time.perf_counter()
        run.step(STEPS)
        times.append(time.perf_counter() - before)
    run.close()
    return min(times)


def main() -> None:
    """Print a table."""
    chunks = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    say = sys.stdout.write
    say(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}, the fastest of {chunks} chunks\n")
    say("FMI  FMUs  in process  isolated  difference  [us a step and FMU]\n")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        faulty.build(folder)
        for version in (2, 3):
            for n in (1, 5):
                file = folder / "chain.yaml"
                file.write_text(system(n, version, STEPS * chunks))
                inside = done_apart(lambda file=file: seconds(file, (), chunks)) / STEPS / n * 1e6
                outside = done_apart(lambda file=file: seconds(file, ("all",), chunks)) / STEPS / n * 1e6
                say(f"{version:3d}  {n:4d}  {inside:10.2f}  {outside:8.2f}  {outside - inside:10.2f}\n")


if __name__ == "__main__":
    main()
