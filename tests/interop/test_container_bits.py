"""Side by side in our master and in FMPy's container FMU: equal to the last bit over 100 000 steps."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

from master.api import prepare_to_run
from master.experiment.experiment import Experiment
from master.stepping.simulate import simulate
from master.system.grid import Grid
from tests.interop.container import build_system_container

pytestmark = pytest.mark.slow

CONFIGS = Path(__file__).parents[2] / "configs"
STEP, N_STEPS, LINKS = 1e-3, 100_000, 5


def docking_loop() -> dict:
    """The paper's loop at low frequency with its compensator and its noise."""
    given = yaml.safe_load((CONFIGS / "low_frequency.yaml").read_text(encoding="utf-8"))
    return {key: given[key] for key in ("fmus", "connections")}


def ring() -> dict:
    """Overdamped masses, each of which follows its neighbour."""
    parameters = {"mass": 2e-4, "damping": 0.04, "stiffness": 1.0}
    starts = [{"y": math.sin(2.0 * math.pi * i / LINKS)} for i in range(LINKS)]
    fmus = {
        f"link{i}": {"source": "oscillator", "parameters": parameters, "start": starts[i]}
        for i in range(LINKS)
    }
    wires = [{"from": f"link{i}.y", "to": f"link{(i + 1) % LINKS}.u"} for i in range(LINKS)]
    return {"fmus": fmus, "connections": wires}


def side_by_side(system: dict, folder: Path) -> Experiment:
    """Prepare a system whose FMUs all step on the values from before."""
    given = {"name": "system", "step_size": STEP, "stop_time": STEP * N_STEPS, **system}
    given["coupling"] = {"order": [list(system["fmus"])]}
    file = folder / "system.yaml"
    file.write_text(yaml.safe_dump(given))
    return prepare_to_run(file)


def in_container(file: Path, names: list[str]) -> np.ndarray:
    """Rows of named signals, one call of the container a step."""
    description = read_model_description(file)
    by_name = {v.name: v.valueReference for v in description.modelVariables}
    references = [by_name[name] for name in names]
    fmu = FMU2Slave(
        instanceName="container",
        guid=description.guid,
        unzipDirectory=extract(str(file)),
        modelIdentifier=description.coSimulation.modelIdentifier,
    )
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    rows = [fmu.getReal(references)]
    for k in range(N_STEPS):
        fmu.doStep(k * STEP, STEP)
        rows.append(fmu.getReal(references))
    fmu.terminate()
    fmu.freeInstance()
    return np.array(rows)


@pytest.mark.parametrize("make", [docking_loop, ring])
def test_all_outputs_are_equal_to_the_last_bit(make, tmp_path: Path) -> None:
    experiment = side_by_side(make(), tmp_path)
    system = experiment.system
    result = simulate(system, experiment.schedule, Grid(0.0, STEP, N_STEPS)).result
    first = {w.target.name: float(result[w.source.name][0]) for w in system.wires}
    container = build_system_container(system, first, STEP, tmp_path)
    names = [v.name for v in read_model_description(container).modelVariables if v.causality == "output"]

    assert len(names) >= 2 * len(system.instances)
    ours = np.column_stack([result[name] for name in names])
    assert ours.tobytes() == in_container(container, names).tobytes()
