"""The compensator alone inside FMPy's container FMU: the container's variables are those of the FMU."""

from __future__ import annotations

import copy
from pathlib import Path

from experiment_in_fmu import Vectors
from fmpy import read_model_description
from fmpy.container_fmu.cli import create_container_fmu
from fmpy.container_fmu.config import Component, Configuration
from fmpy.model_description import CoSimulation, DefaultExperiment, ModelDescription, ModelVariable, Unknown


def build_container(given: Vectors, folder: Path) -> Path:
    """Put the FMU of the vectors (FMI 2.0) into a container FMU with the parameters as start values."""
    inner = read_model_description(given.fmu)
    component = Component("compensator", given.fmu, inner)
    chosen = {*given.input_names, *given.output_names, *given.parameters}
    pairs = [(container_variable(v, given), v) for v in inner.modelVariables if v.name in chosen]
    description = describe([mine for mine, _ in pairs], given)
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


def describe(variables: list, given: Vectors) -> ModelDescription:
    """Describe the container."""
    description = ModelDescription()
    description.fmiVersion, description.modelName, description.guid = "2.0", "Container", "{container}"
    description.instantiationToken = "{container}"
    description.variableNamingConvention = "structured"
    description.coSimulation = CoSimulation()
    description.coSimulation.canHandleVariableCommunicationStepSize = True
    description.coSimulation.fixedInternalStepSize = given.step
    description.defaultExperiment = DefaultExperiment(
        startTime="0", stopTime="0.25", stepSize=repr(given.step)
    )
    description.modelVariables = [time_variable(), *variables]
    unknowns = [Unknown(variable=v) for v in variables if v.causality == "output"]
    description.outputs = description.initialUnknowns = unknowns
    return description
