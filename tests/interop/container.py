"""FMPy's container FMU: the compensator alone in it, or a whole system whose FMUs step side by side."""

from __future__ import annotations

import copy
from pathlib import Path

from fmpy import read_model_description
from fmpy.container_fmu.cli import create_container_fmu
from fmpy.container_fmu.config import Component, Configuration, Connection
from fmpy.model_description import CoSimulation, DefaultExperiment, ModelDescription, ModelVariable, Unknown

from master.fmi.description import Kind
from master.system.graph import System
from tests.interop.experiment_in_fmu import Vectors


def build_container(given: Vectors, folder: Path) -> Path:
    """Put the FMU of the vectors (FMI 2.0) into a container FMU with the parameters as start values."""
    inner = read_model_description(given.fmu)
    component = Component("compensator", given.fmu, inner)
    chosen = {*given.input_names, *given.output_names, *given.parameters}
    pairs = [(container_variable(v, given), v) for v in inner.modelVariables if v.name in chosen]
    description = describe([mine for mine, _ in pairs], given.step)
    mappings = {mine: [(component, its)] for mine, its in pairs}
    configuration = Configuration(False, description, [component], [], mappings)
    unzipped = folder / "unzipped"
    unzipped.mkdir()
    create_container_fmu(configuration, unzipped, folder / "container.fmu")
    return folder / "container.fmu"


def container_variable(v, given: Vectors):
    """Copy a variable; the unit stays behind, for the container defines none."""
    mine = copy.copy(v)
    mine.unit = mine.declaredType = None
    if v.name in given.parameters:
        mine.start = repr(given.parameters[v.name])
    elif v.causality == "input":
        mine.start = repr(float(given.inputs[v.name][0]))
    return mine


def time_variable() -> ModelVariable:
    """Stand first: the container's library counts its value references from behind the time."""
    return ModelVariable(name="time", type="Real", causality="independent", variability="continuous")


def describe(variables: list, step: float) -> ModelDescription:
    """Describe the container."""
    description = ModelDescription()
    description.fmiVersion, description.modelName, description.guid = "2.0", "Container", "{container}"
    description.instantiationToken = "{container}"
    description.variableNamingConvention = "structured"
    description.coSimulation = CoSimulation()
    description.coSimulation.canHandleVariableCommunicationStepSize = True
    description.coSimulation.fixedInternalStepSize = step
    description.defaultExperiment = DefaultExperiment(startTime="0", stopTime="0.25", stepSize=repr(step))
    description.modelVariables = [time_variable(), *variables]
    unknowns = [Unknown(variable=v) for v in variables if v.causality == "output"]
    description.outputs = description.initialUnknowns = unknowns
    return description


def build_system_container(system: System, received: dict[str, float], step: float, folder: Path) -> Path:
    """
    Put a system into a container; its real outputs are those of the container, named as in the system.

    The container hands nothing through its connections before the first step: `received` are the values
    that the connected inputs have then.
    """
    components = {
        name: Component(name, i.description.path, read_model_description(i.description.path))
        for name, i in system.instances.items()
    }
    inner = {f"{n}.{v.name}": v for n, c in components.items() for v in c.modelDescription.modelVariables}
    mappings = {}
    for name, instance in system.instances.items():
        start = dict(instance.start) | {
            w.target.variable.name: received[w.target.name] for w in system.wires_into(name)
        }
        shown = [v.name for v in instance.description.outputs if v.kind is Kind.REAL]
        for key in dict.fromkeys([*start, *shown]):
            mine = system_variable(f"{name}.{key}", inner[f"{name}.{key}"], start.get(key))
            mappings[mine] = [(components[name], inner[f"{name}.{key}"])]
    connections = []
    for wire in system.wires:
        source = copy.copy(inner[wire.source.name])
        source.type = "Float64"  # as shipped the container knows no "Real" here
        ends = components[wire.source.instance], components[wire.target.instance]
        connections.append(Connection(ends[0], [source], ends[1], [inner[wire.target.name]]))
    description = describe(list(mappings), step)
    configuration = Configuration(False, description, list(components.values()), connections, mappings)
    (folder / "unzipped").mkdir()
    create_container_fmu(configuration, folder / "unzipped", folder / "container.fmu")
    return folder / "container.fmu"


def system_variable(name: str, v: ModelVariable, start: float | None) -> ModelVariable:
    """Copy a variable under the name of the system, with a start value if it has one there."""
    mine = copy.copy(v)
    mine.name, mine.unit, mine.declaredType = name, None, None
    mine.type = "Integer" if v.type == "Enumeration" else v.type
    if start is not None:
        mine.start = {"Real": repr(start), "Boolean": str(bool(start)).lower()}.get(v.type, str(int(start)))
    elif v.initial != "exact":
        mine.start = None
    return mine
