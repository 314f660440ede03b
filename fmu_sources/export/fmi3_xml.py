"""modelDescription.xml of FMI 3.0 from a model's declarations, for the native flavour."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from ..framework.model import Model
from ..framework.variables import Role, Variable
from .dependencies import initial_dependencies
from .facts import (
    DATE,
    STEP_SIZE,
    TOOL,
    Flavour,
    add_coupling_facts,
    add_log_categories,
    add_unit_definitions,
    bounds,
    causality,
    document,
    enumerations,
    fmi_variables,
    is_output,
    start_text,
    type_name,
    variability,
)


def time_reference(model: Model) -> int:
    """Value reference of the independent variable: the first behind all others."""
    return len(model.all_variables)


def describe_fmi3(model: Model, flavour: Flavour, token: str) -> bytes:
    """Write modelDescription.xml of FMI 3.0; `token` is the instantiation token."""
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=model.name,
        instantiationToken=token,
        description=model.description,
        license="BSD-3-Clause",
        generationTool=f"{TOOL} ({flavour.name})",
        generationDateAndTime=DATE,
        variableNamingConvention="structured",
    )
    _co_simulation(root, model, flavour)
    add_unit_definitions(root, model)
    _type_definitions(root, model)
    add_log_categories(root)
    ET.SubElement(root, "DefaultExperiment", startTime="0.0", stopTime="10.0", stepSize=repr(STEP_SIZE))
    _model_variables(root, model)
    _model_structure(root, model)
    annotations = ET.SubElement(root, "Annotations")
    add_coupling_facts(ET.SubElement(annotations, "Annotation", type=TOOL), model)
    return document(root)


def _co_simulation(root: ET.Element, model: Model, flavour: Flavour) -> None:
    ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=model.name,
        needsExecutionTool=str(flavour.needs_execution_tool).lower(),
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
        providesDirectionalDerivatives=str(flavour.directional_derivatives).lower(),
        hasEventMode="false",
    )


def _type_definitions(root: ET.Element, model: Model) -> None:
    found = enumerations(model)
    if not found:
        return
    types = ET.SubElement(root, "TypeDefinitions")
    for name, v in found.items():
        enumeration = ET.SubElement(types, "EnumerationType", name=name)
        for item in v.items or ():
            ET.SubElement(enumeration, "Item", name=item.name, value=str(item.value))


def _model_variables(root: ET.Element, model: Model) -> None:
    variables = ET.SubElement(root, "ModelVariables")
    calculated = initial_dependencies(model)
    ET.SubElement(
        variables,
        "Float64",
        name="time",
        valueReference=str(time_reference(model)),
        causality="independent",
        variability="continuous",
        description="simulation time",
    )
    for reference, v in fmi_variables(model):
        tag, typed = _type(v)
        element = ET.SubElement(variables, tag, name=v.name, valueReference=str(reference))
        element.attrib |= {"description": v.description, "causality": causality(v)}
        element.set("variability", variability(model, v))
        if v.role is not Role.INPUT:
            element.set("initial", "calculated" if v.name in calculated else "exact")
        element.attrib |= typed
        if v.name not in calculated:
            element.set("start", start_text(v))


def _type(v: Variable) -> tuple[str, dict[str, str]]:
    if v.items is not None:
        return "Enumeration", {"declaredType": type_name(v)}
    if v.boolean:
        return "Boolean", {}
    if v.integer:
        return "Int32", bounds(v, int)
    return "Float64", {"unit": v.unit, **bounds(v, float)}


def _model_structure(root: ET.Element, model: Model) -> None:
    reference = {v.name: i for i, v in fmi_variables(model)}
    calculated = initial_dependencies(model)
    structure = ET.SubElement(root, "ModelStructure")
    shown = [v for _, v in fmi_variables(model) if is_output(v)]
    for v in shown:
        ET.SubElement(structure, "Output", valueReference=str(reference[v.name]), dependencies="")
    for v in shown:
        if v.name in calculated:
            on = " ".join(str(reference[name]) for name in calculated[v.name] if name in reference)
            unknown = ET.SubElement(structure, "InitialUnknown", valueReference=str(reference[v.name]))
            unknown.set("dependencies", on)
