"""Run in an environment with ecospy: an FMU and an experiment (JSON) in, rows of outputs (JSON) out."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from ecospy import EcosSimulation, EcosSimulationStructure


def main(fmu: str, experiment: str) -> None:
    given = json.loads(Path(experiment).read_text())
    starts = {**given["parameters"], **dict(zip(given["inputs"], given["rows"][0], strict=True))}
    with EcosSimulationStructure() as structure:
        structure.add_model("fmu", fmu)
        structure.add_parameter_set("starts", {f"fmu::{name}": value for name, value in starts.items()})
        with EcosSimulation(structure=structure, step_size=given["step"]) as simulation:
            assert simulation.init(parameter_set="starts")
            sys.stdout.write(json.dumps(list(answers(simulation, given))))
            simulation.terminate()


def answers(simulation: EcosSimulation, given: dict):
    """Give the outputs at the start and after each step."""
    yield [simulation.get_real(f"fmu::{name}") for name in given["outputs"]]
    for row in given["rows"][:-1]:
        for name, value in zip(given["inputs"], row, strict=True):
            simulation.set_real(f"fmu::{name}", value)
        simulation.step()
        yield [simulation.get_real(f"fmu::{name}") for name in given["outputs"]]


if __name__ == "__main__":
    main(*sys.argv[1:])
