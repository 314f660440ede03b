"""Our master: the whole run loop, with recording, after compilation and initialisation."""

from __future__ import annotations

import sys
from importlib.metadata import version
from pathlib import Path

from measure import answer, timed

import dockloop as dl


def main(spec_path: str, n_steps: str) -> None:
    """Step a system and answer."""
    system = dl.load(Path(spec_path).with_name("system.yaml"))
    with system.open(stop_time=int(n_steps) * system.step_size) as sim:
        seconds = timed(lambda: sim.step(int(n_steps)))
        run = sim.result()
    assert len(run) == int(n_steps) + 1
    answer(seconds, int(n_steps), version("dockloop"), [(name, float(run[name][-1])) for name in run.signals])


if __name__ == "__main__":
    main(*sys.argv[1:])
