"""Ecos through ecospy: FMUs side by side; its CSV writer records all outputs."""

from __future__ import annotations

import json
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

from ecospy import EcosSimulation, EcosSimulationStructure
from measure import answer, timed


def main(spec_path: str, n_steps: str) -> None:
    """Step a system and answer; Ecos writes the outputs itself, through its CSV writer."""
    spec = json.loads(Path(spec_path).read_text(encoding="utf-8"))
    fmus = spec["fmus"]
    start = {f"{name}::{v}": x for name, given in fmus.items() for v, x in given["start"].items()}
    reals = [(n, v) for n, g in fmus.items() for v in g["outputs"] if g["kinds"][v] == "Real"]
    with tempfile.TemporaryDirectory() as folder, EcosSimulationStructure() as structure:
        for name, given in fmus.items():
            structure.add_model(name, given["path"])
        for source, target in spec["connections"]:
            structure.make_real_connection(source.replace(".", "::"), target.replace(".", "::"))
        structure.add_parameter_set("start", start)
        with EcosSimulation(structure=structure, step_size=spec["step_size"]) as simulation:
            simulation.add_csv_writer(str(Path(folder) / "result.csv"))
            assert simulation.init(parameter_set="start")
            seconds = timed(lambda: simulation.step(int(n_steps)))
            final = [(f"{n}.{v}", simulation.get_real(f"{n}::{v}")) for n, v in reals]
            simulation.terminate()
    answer(seconds, int(n_steps), version("ecospy"), final)


if __name__ == "__main__":
    main(*sys.argv[1:])
