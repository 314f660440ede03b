"""FMPy's FMU2Slave in a Python loop: for each FMU one call for all inputs, one step, one for its outputs."""

from __future__ import annotations

import json
import sys
from importlib.metadata import version
from pathlib import Path

from fmpy import extract
from fmpy.fmi2 import FMU2Slave
from measure import answer, timed


class Fmu:
    """One FMU with the places of its ports in the table of values."""

    def __init__(self, name: str, given: dict, connections: list[list[str]]) -> None:
        self.slave = FMU2Slave(
            instanceName=name,
            guid=given["token"],
            unzipDirectory=extract(given["path"]),
            modelIdentifier=given["identifier"],
        )
        self.slave.instantiate()
        setters = {
            "Real": self.slave.setReal,
            "Boolean": self.slave.setBoolean,
            "Integer": self.slave.setInteger,
        }
        for variable, value in given["start"].items():
            setters[given["kinds"][variable]]([given["references"][variable]], [value])
        incoming = [c for c in connections if c[1].split(".", 1)[0] == name]
        self.sources = [source for source, _ in incoming]
        self.inputs = [given["references"][target.split(".", 1)[1]] for _, target in incoming]
        reals = [v for v in given["outputs"] if given["kinds"][v] == "Real"]
        self.signals = [f"{name}.{v}" for v in reals]
        self.outputs = [given["references"][v] for v in reals]
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()

    def pull(self, table: dict[str, float]) -> None:
        """Set the inputs."""
        if self.inputs:
            self.slave.setReal(self.inputs, [table[s] for s in self.sources])

    def read(self, table: dict[str, float]) -> None:
        """Read the outputs."""
        table.update(zip(self.signals, self.slave.getReal(self.outputs), strict=True))


def main(spec_path: str, n_steps: str) -> None:
    """Step a system and answer."""
    spec = json.loads(Path(spec_path).read_text(encoding="utf-8"))
    fmus = {name: Fmu(name, given, spec["connections"]) for name, given in spec["fmus"].items()}
    table: dict[str, float] = {}
    for fmu in fmus.values():
        fmu.read(table)
    for _ in range(3):
        for fmu in fmus.values():
            fmu.pull(table)
            fmu.read(table)
    for fmu in fmus.values():
        fmu.slave.exitInitializationMode()
    groups = [[fmus[name] for name in group] for group in spec["order"]]
    rows: list[list[float]] = []

    def run() -> None:
        h = spec["step_size"]
        for k in range(int(n_steps)):
            for group in groups:
                for fmu in group:
                    fmu.pull(table)
                for fmu in group:
                    fmu.slave.doStep(k * h, h)
                    fmu.read(table)
            rows.append(list(table.values()))

    answer(timed(run), int(n_steps), version("fmpy"), table.items())


if __name__ == "__main__":
    main(*sys.argv[1:])
