"""
FMPy's container FMU: all FMUs inside one, stepped side by side by its C code, some steps a call.

As shipped it does not know the type "Real" of a connection of FMI 2.0; the type is given as "Float64".
It is read after each call: with one step a call it records as much as the others, with 1000 a thousandth.
"""

from __future__ import annotations

import copy
import json
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.container_fmu.cli import create_container_fmu
from fmpy.container_fmu.config import Component, Configuration, Connection
from fmpy.fmi2 import FMU2Slave
from fmpy.model_description import CoSimulation, DefaultExperiment, ModelDescription, ModelVariable, Unknown
from measure import answer, timed


def main(spec_path: str, n_steps: str, steps_a_call: str) -> None:
    """Step a system and answer."""
    spec = json.loads(Path(spec_path).read_text(encoding="utf-8"))
    description, configuration = configure(spec)
    outputs = [v for v in description.modelVariables if v.causality == "output"]
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "unzipped").mkdir()
        file = Path(folder) / "container.fmu"
        create_container_fmu(configuration, Path(folder) / "unzipped", file)
        slave = FMU2Slave(
            instanceName="container",
            guid=description.guid,
            unzipDirectory=extract(str(file)),
            modelIdentifier="container_fmu",
        )
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        references = [v.valueReference for v in outputs]
        h = int(steps_a_call) * spec["step_size"]
        rows: list[list[float]] = []

        def run() -> None:
            for k in range(int(n_steps) // int(steps_a_call)):
                slave.doStep(k * h, h)
                rows.append(slave.getReal(references))

        seconds = timed(run)
    answer(seconds, int(n_steps), version("fmpy"), zip([v.name for v in outputs], rows[-1], strict=True))


def configure(spec: dict) -> tuple[ModelDescription, Configuration]:
    """Describe the container: start values and outputs go through, wires stay inside."""
    components, variables, mappings = {}, {}, {}
    for name, given in spec["fmus"].items():
        inner = read_model_description(given["path"])
        components[name] = Component(name, Path(given["path"]), inner)
        for v in inner.modelVariables:
            variables[f"{name}.{v.name}"] = v
            is_output = v.name in given["outputs"] and v.type == "Real"
            if is_output or v.name in given["start"]:
                mine = container_variable(f"{name}.{v.name}", v, given["start"].get(v.name))
                mappings[mine] = [(components[name], v)]
    connections = []
    for source, target in spec["connections"]:
        start, end = copy.copy(variables[source]), variables[target]
        start.type = "Float64"
        ends = (components[source.split(".")[0]], [start], components[target.split(".")[0]], [end])
        connections.append(Connection(*ends))
    description = describe(list(mappings), spec["step_size"])
    return description, Configuration(False, description, list(components.values()), connections, mappings)


def container_variable(name: str, v: ModelVariable, start: float | None) -> ModelVariable:
    """Copy a variable without its unit and type definition, for the container defines none."""
    mine = copy.copy(v)
    mine.name, mine.unit, mine.declaredType = name, None, None
    mine.type = "Integer" if v.type == "Enumeration" else v.type
    if start is not None:
        mine.start = str(start).lower() if v.type == "Boolean" else repr(start)
    elif v.causality == "output":
        mine.start = None
    return mine


def describe(variables: list[ModelVariable], step: float) -> ModelDescription:
    """Write the container's own description; the time stands first, as its library counts."""
    time = ModelVariable(name="time", type="Real", causality="independent", variability="continuous")
    description = ModelDescription()
    description.fmiVersion, description.modelName, description.guid = "2.0", "Container", "{container}"
    description.instantiationToken = "{container}"
    description.variableNamingConvention = "structured"
    description.coSimulation = CoSimulation()
    description.coSimulation.canHandleVariableCommunicationStepSize = True
    description.coSimulation.fixedInternalStepSize = step
    description.defaultExperiment = DefaultExperiment(startTime="0", stopTime="1", stepSize=repr(step))
    description.modelVariables = [time, *variables]
    description.outputs = [Unknown(variable=v) for v in variables if v.causality == "output"]
    description.initialUnknowns = description.outputs
    return description


if __name__ == "__main__":
    main(*sys.argv[1:])
