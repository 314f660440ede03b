"""
What it costs to step FMUs in processes of their own.

    python -m tests.reliability.isolation_cost [--chunks 100] [--ecos]

The same systems in process and isolated: the fastest chunk of 200 steps of each, so that what else the
machine does counts as little as may be, and the processor time of all processes over all chunks, in which
each side waits for the other awake. With `--ecos` the same FMU in Ecos, in process and by its own proxies
(`pip install ecospy` into an environment of its own), right after ours.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from benchmarks.peers import LONGEST, MASTERS, RUNNERS, python_of
from master.api import prepare_to_run
from master.experiment.prepare import Request
from master.process.child import done_apart
from master.stepping.opened import OpenRun
from master.stepping.outcome import RunOptions
from tests.foreign import faulty
from tests.reliability.soak import family

STEPS = 200


def system(n: int, version: int, steps: int) -> str:
    """Return a chain of n FMUs."""
    fmus = "".join(f"  f{i}: {{source: faulty{version}.fmu}}\n" for i in range(n))
    order = ", ".join(f"f{i}" for i in range(n))
    wires = "".join(f"  - {{from: f{i}.x, to: f{i + 1}.input}}\n" for i in range(n - 1))
    head = f"name: chain\nstep_size: 0.001\nstop_time: {steps / 1000}\nfmus:\n"
    return f"{head}{fmus}coupling: {{order: [{order}]}}\n" + (f"connections:\n{wires}" if wires else "")


@dataclass(frozen=True)
class Cost:
    """Of a step and FMU [us]: wall time in the fastest chunk, processor time over all chunks."""

    wall: float
    processor: float


def processor_time() -> float:
    """Processor time of this process and those that it began, which are there still [s]."""
    ticks = 0
    for number in family(os.getpid()):
        fields = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def cost(file: Path, n_fmus: int, isolate: tuple[str, ...], chunks: int) -> Cost:
    """Step a system in chunks."""
    experiment = prepare_to_run(file, Request(isolate=isolate))
    run = OpenRun(experiment.system, experiment.schedule, experiment.grid, RunOptions())
    run.step(1)
    times = []
    begin = processor_time()
    for _ in range(chunks):
        before = time.perf_counter()
        run.step(STEPS)
        times.append(time.perf_counter() - before)
    used = processor_time() - begin
    run.close()
    return Cost(min(times) / STEPS / n_fmus * 1e6, used / chunks / STEPS / n_fmus * 1e6)


def cost_of_ecos(fmu: Path, n_fmus: int, chunks: int) -> tuple[float, float]:
    """Wall time of a step and FMU in Ecos, in process and by its proxies [us]."""
    python = python_of(next(one for one in MASTERS if one.runner == "ecos"))
    command = [python, RUNNERS / "ecos_proxy.py", fmu, str(n_fmus), str(STEPS), str(chunks)]
    done = subprocess.run(
        command,
        check=True,
        capture_output=True,
        text=True,
        timeout=LONGEST,
        cwd=fmu.parent,  # its proxies write logs
    )
    found = json.loads(done.stdout.splitlines()[-1])
    return found["inside"] / STEPS / n_fmus * 1e6, found["isolated"] / STEPS / n_fmus * 1e6


def main(chunks: int = 100, *, ecos: bool = False) -> None:
    """Print a table."""
    say = sys.stdout.write
    say(f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}, the fastest of {chunks} chunks\n")
    say("FMI  FMUs  in process  isolated  difference  processor time, isolated  [us a step and FMU]\n")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        faulty.build(folder)
        for version in (2, 3):
            for n in (1, 5):
                file = folder / "chain.yaml"
                file.write_text(system(n, version, STEPS * chunks + 1))
                inside = done_apart(partial(cost, file, n, (), chunks))
                outside = done_apart(partial(cost, file, n, ("all",), chunks))
                more = outside.wall - inside.wall
                say(f"{version:3d}  {n:4d}  {inside.wall:10.2f}  {outside.wall:8.2f}  {more:10.2f}")
                say(f"  {outside.processor:24.2f}\n")
                if ecos:
                    own, proxies = cost_of_ecos(folder / f"faulty{version}.fmu", n, chunks)
                    say(f"     Ecos  {own:10.2f}  {proxies:8.2f}  {proxies - own:10.2f}\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--chunks", type=int, default=100)
    parser.add_argument("--ecos", action="store_true")
    main(**vars(parser.parse_args()))
