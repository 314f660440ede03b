"""A fused FMU under FMPy, and the rows of `dockloop run` to compare with."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path

import numpy as np
import yaml
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

from fmu_sources.export import build
from master.api import prepare_to_run
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request
from master.fuse.export import fused_fmu, fused_system
from master.stepping.outcome import RunOptions
from master.stepping.simulate import simulate

GETTERS = {
    ("2.0", "Real"): "getReal",
    ("2.0", "Integer"): "getInteger",
    ("2.0", "Enumeration"): "getInteger",
    ("2.0", "Boolean"): "getBoolean",
    ("3.0", "Float64"): "getFloat64",
    ("3.0", "Int32"): "getInt32",
    ("3.0", "Enumeration"): "getInt64",
    ("3.0", "Boolean"): "getBoolean",
}


class Host:
    """One instance of a fused FMU, from its instantiation to its end."""

    def __init__(self, fmu: Path, name: str = "host"):
        self.folder = extract(str(fmu))
        self.about = read_model_description(str(fmu))
        self.variables = {v.name: v for v in self.about.modelVariables}
        self.is_2 = self.about.fmiVersion == "2.0"
        make = FMU2Slave if self.is_2 else FMU3Slave
        self.fmu = make(
            guid=self.about.guid or self.about.instantiationToken,
            unzipDirectory=self.folder,
            modelIdentifier=self.about.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.messages: list[str] = []
        if self.is_2:
            self.fmu.instantiate()
        else:
            self.fmu.instantiate(
                logMessage=lambda _, status, category, text: self.messages.append(text.decode())
            )

    def start(self, t0: float = 0.0, **values: float):
        self.enter(t0)
        for name, value in values.items():
            self.set(name.replace("__", "."), value)
        self.fmu.exitInitializationMode()
        return self

    def enter(self, t0: float = 0.0):
        if self.is_2:
            self.fmu.setupExperiment(startTime=t0)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=t0)

    def set(self, name: str, value: float):
        v = self.variables[name]
        getattr(self.fmu, GETTERS[self.about.fmiVersion, v.type].replace("get", "set"))(
            [v.valueReference], [value]
        )

    def get(self, *names: str) -> list[float]:
        found = []
        for name in names:
            v = self.variables[name]
            found += getattr(self.fmu, GETTERS[self.about.fmiVersion, v.type])([v.valueReference])
        return [float(x) for x in found]

    def rows(self, names, n: int, h: float, t0: float = 0.0) -> np.ndarray:
        found = [self.get(*names)]
        for k in range(n):
            self.fmu.doStep(t0 + k * h, h)
            found.append(self.get(*names))
        return np.array(found)

    def end(self):
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


def bare(folder: Path, model: str) -> Path:
    """Write a model of this project as the FMU of another tool, without its sources."""
    path = folder / f"bare_{model}.fmu"
    with zipfile.ZipFile(build.target(model).path) as archive, zipfile.ZipFile(path, "w") as copy:
        for name in archive.namelist():
            if not name.startswith("sources/"):
                content = archive.read(name)
                copy.writestr(name, content.replace(b"dockloop (native flavour)", b"another tool"))
    return path


def prepared(folder: Path, data: dict | str | Path, **request) -> Experiment:
    """Prepare a system: the name of a shipped one, or what its file would hold."""
    if isinstance(data, dict):
        path = folder / "system.yaml"
        path.write_text(yaml.safe_dump(data), encoding="utf-8")
        data = path
    return prepare_to_run(Path(data), Request(**request))


def exported(experiment: Experiment, folder: Path, version: str = "2.0") -> Path:
    path = folder / f"fused_{version[0]}.fmu"
    path.write_bytes(fused_fmu(fused_system(experiment, carries=True), version))
    return path


def expected_rows(experiment: Experiment):
    options = RunOptions(scenario=experiment.scenario)
    result = simulate(experiment.system, experiment.schedule, experiment.grid, options=options).result
    return list(result.names), np.ascontiguousarray(result.values)


def assert_same_bits(experiment: Experiment, fmu: Path) -> None:
    names, values = expected_rows(experiment)
    host = Host(fmu).start(experiment.grid.t0)
    rows = host.rows(names, experiment.grid.n_ticks, experiment.grid.step_size, experiment.grid.t0)
    host.end()
    different = [name for j, name in enumerate(names) if rows[:, j].tobytes() != values[:, j].tobytes()]

    assert len(np.unique(values)) > len(names), "a system in which nothing happens shows nothing"
    assert different == []
