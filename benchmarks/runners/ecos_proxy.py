"""Ecos' own processes for FMUs (proxyfmu, part of ecospy), and Ecos without them: a chain of one FMU."""

from __future__ import annotations

import json
import os
import stat
import sys
import time
from itertools import pairwise
from pathlib import Path

import ecospy
from ecospy import EcosSimulation, EcosSimulationStructure

PROXY = "proxyfmu://localhost?file="
STEP_SIZE = 0.001  # s


def fastest(source: str, n_fmus: int, steps: int, chunks: int) -> float:
    """Return the wall time of the fastest chunk of steps [s]."""
    with EcosSimulationStructure() as structure:
        names = [f"f{i}" for i in range(n_fmus)]
        for name in names:
            structure.add_model(name, source)
        for before, after in pairwise(names):
            structure.make_real_connection(f"{before}::x", f"{after}::input")
        with EcosSimulation(structure=structure, step_size=STEP_SIZE) as simulation:
            assert simulation.init()
            times = []
            for _ in range(chunks):
                begin = time.perf_counter()
                simulation.step(steps)
                times.append(time.perf_counter() - begin)
            simulation.terminate()
    return min(times)


def main(fmu: str, n_fmus: str, steps: str, chunks: str) -> None:
    """Print both times as JSON, as the last line."""
    executable = Path(ecospy.__file__).parent / "binaries" / "proxyfmu"
    executable.chmod(executable.stat().st_mode | stat.S_IXUSR)  # the wheel loses it
    os.environ["PATH"] += f"{os.pathsep}{executable.parent}"
    numbers = int(n_fmus), int(steps), int(chunks)
    answer = {"inside": fastest(fmu, *numbers), "isolated": fastest(PROXY + fmu, *numbers)}
    sys.stdout.write(f"\n{json.dumps(answer)}\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
