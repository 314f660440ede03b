"""modelDescription.xml of FMI 2.0 from a model's declarations, for every flavour."""

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


def describe_fmi2(model: Model, flavour: Flavour, token: str, c_files: tuple[str, ...] = ()) -> bytes:
    """Write modelDescription.xml of FMI 2.0; `token` is the GUID, `c_files` stand in `sources/`."""
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=model.name,
        guid=token,
        description=model.description,
        license="BSD-3-Clause",
        generationTool=f"{TOOL} ({flavour.name})",
        generationDateAndTime=DATE,
        variableNamingConvention="structured",
        numberOfEventIndicators="0",
    )
    _co_simulation(root, model, flavour, c_files)
    add_unit_definitions(root, model)
    _type_definitions(root, model)
    add_log_categories(root)
    ET.SubElement(root, "DefaultExperiment", startTime="0.0", stopTime="10.0", stepSize=repr(STEP_SIZE))
    annotations = ET.SubElement(root, "VendorAnnotations")
    add_coupling_facts(ET.SubElement(annotations, "Tool", name=TOOL), model)
    _model_variables(root, model)
    _model_structure(root, model)
    return document(root)


def _co_simulation(root: ET.Element, model: Model, flavour: Flavour, c_files: tuple[str, ...]) -> None:
    element = ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=model.name,
        needsExecutionTool=str(flavour.needs_execution_tool).lower(),
        canHandleVariableCommunicationStepSize="true",
        canInterpolateInputs="false",
        canBeInstantiatedOnlyOncePerProcess=str(flavour.once_per_process).lower(),
        canNotUseMemoryManagementFunctions="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        providesDirectionalDerivative=str(flavour.directional_derivatives).lower(),
    )
    if c_files:
        sources = ET.SubElement(element, "SourceFiles")
        for name in c_files:
            ET.SubElement(sources, "File", name=name)


def _type_definitions(root: ET.Element, model: Model) -> None:
    found = enumerations(model)
    if not found:
        return
    types = ET.SubElement(root, "TypeDefinitions")
    for name, v in found.items():
        simple = ET.SubElement(ET.SubElement(types, "SimpleType", name=name), "Enumeration")
        for item in v.items or ():
            ET.SubElement(simple, "Item", name=item.name, value=str(item.value))


def _model_variables(root: ET.Element, model: Model) -> None:
    variables = ET.SubElement(root, "ModelVariables")
    calculated = initial_dependencies(model)
    for reference, v in fmi_variables(model):
        scalar = ET.SubElement(
            variables,
            "ScalarVariable",
            name=v.name,
            valueReference=str(reference),
            description=v.description,
            causality=causality(v),
            variability=variability(model, v),
        )
        if v.role is not Role.INPUT:
            scalar.set("initial", "calculated" if v.name in calculated else "exact")
        _typed(scalar, v, with_start=v.name not in calculated)


def _typed(scalar: ET.Element, v: Variable, *, with_start: bool) -> None:
    if v.items is not None:
        typed = ET.SubElement(scalar, "Enumeration", declaredType=type_name(v))
    elif v.boolean:
        typed = ET.SubElement(scalar, "Boolean")
    elif v.integer:
        typed = ET.SubElement(scalar, "Integer", bounds(v, int))
    else:
        typed = ET.SubElement(scalar, "Real", {"unit": v.unit, **bounds(v, float)})
    if with_start:
        typed.set("start", start_text(v))


def _model_structure(root: ET.Element, model: Model) -> None:
    place = {v.name: i for i, (_, v) in enumerate(fmi_variables(model), start=1)}
    structure = ET.SubElement(root, "ModelStructure")
    outputs = ET.SubElement(structure, "Outputs")
    calculated = initial_dependencies(model)
    shown = [v for _, v in fmi_variables(model) if is_output(v)]
    for v in shown:
        ET.SubElement(outputs, "Unknown", index=str(place[v.name]), dependencies="")
    unknown = [v for v in shown if v.name in calculated]
    if unknown:
        initial = ET.SubElement(structure, "InitialUnknowns")
    for v in unknown:
        indices = " ".join(str(place[name]) for name in calculated[v.name] if name in place)
        ET.SubElement(initial, "Unknown", index=str(place[v.name]), dependencies=indices)
