"""Our master: the whole run loop, with recording, after compilation and initialisation."""

from __future__ import annotations

import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
from measure import answer, timed

from master.api import prepare_to_run
from master.stepping.compiler import build_program
from master.stepping.initialisation import initialise
from master.stepping.machine.compiled import compiled
from master.stepping.outcome import RunOptions
from master.stepping.run import RunLoop
from master.stepping.simulate import load
from master.system.grid import Grid


def main(spec_path: str, n_steps: str) -> None:
    """Step a system and answer."""
    experiment = prepare_to_run(Path(spec_path).with_name("system.yaml"))
    system, schedule = experiment.system, experiment.schedule
    slaves = {name: load(name, i.description) for name, i in system.instances.items()}
    initialise(system, schedule, slaves, 0.0)
    program = build_program(system, schedule, slaves)
    grid = Grid(0.0, experiment.config.step_size, int(n_steps))
    loop = RunLoop(system, grid, program, slaves, RunOptions())
    execute = compiled()
    empty = np.empty((0, len(loop.ports)))
    execute(program.memory, loop.monitor, 0.0, grid.step_size, 0, 0, empty)
    seconds = timed(lambda: loop.run(execute, print_nothing))
    result = loop.recorder.result()
    assert len(result.time) == int(n_steps) + 1
    final = zip(result.names, result.values[-1].tolist(), strict=True)
    answer(seconds, int(n_steps), version("dockloop"), final)
    for slave in slaves.values():
        slave.close(failed=False)


def print_nothing(ticks: int) -> None:
    """Take the progress."""


if __name__ == "__main__":
    main(*sys.argv[1:])
