"""Run the reference experiment in PathSim, in a process of its own: FMU, experiment.json, block package."""

from __future__ import annotations

import importlib
import json
import sys

import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Source


def main(fmu: str, experiment: str, package: str) -> None:
    with open(experiment) as file:
        given = json.load(file)
    rows, step = np.array(given["rows"]), given["step"]
    block_of = importlib.import_module(package).CoSimulationFMU
    starts = {**given["parameters"], **dict(zip(given["inputs"], rows[0], strict=True))}
    block = block_of(fmu, start_values=starts, dt=step)
    found = [read(block, given["outputs"])]
    act = block.events[0].func_act

    def note(t: float) -> None:
        act(t)
        found.append(read(block, given["outputs"]))

    block.events[0].func_act = note
    sources = [
        Source(lambda t, i=i: rows[min(round(t / step), len(rows) - 1), i]) for i in range(rows.shape[1])
    ]
    wires = [Connection(source, block[name]) for source, name in zip(sources, given["inputs"], strict=True)]
    simulation = Simulation([*sources, block], wires, dt=step, log=False)
    simulation.run(step * (len(rows) - 1))
    json.dump(np.array(found)[: len(rows)].tolist(), sys.stdout)


def read(block: object, names: list[str]) -> list[float]:
    return [float(block.outputs[name]) for name in names]


if __name__ == "__main__":
    main(*sys.argv[1:])
