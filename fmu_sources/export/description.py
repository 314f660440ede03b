"""modelDescription.xml for FMI 2.0 from a model's declarations: the one writer of all flavours."""

from __future__ import annotations

import hashlib
import uuid
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from ..model import Delay, Model
from ..variables import Role, Variable
from .dependencies import influences, initial_dependencies
from .units import BASE_UNITS, DISPLAY_UNITS, si_exponents

TOOL = "dockloop"
DATE = "2026-01-01T00:00:00Z"
STEP_SIZE = 1e-3


@dataclass(frozen=True)
class Flavour:
    """What differs in the description between the ways of building an FMU."""

    name: str
    needs_execution_tool: bool
    once_per_process: bool = False
    directional_derivatives: bool = False


def guid(*contents: bytes) -> str:
    """Content hash in the form of a GUID."""
    digest = hashlib.sha256()
    for content in contents:
        digest.update(len(content).to_bytes(8, "big") + content)
    return "{" + str(uuid.UUID(bytes=digest.digest()[:16])) + "}"


def fmi_variables(model: Model) -> list[tuple[int, Variable]]:
    """Variables that FMI shows, each with its value reference, its place in `model.all_variables`."""
    return [(i, v) for i, v in enumerate(model.all_variables) if not v.hidden]


def is_output(v: Variable) -> bool:
    """Whether the variable is an FMI output."""
    return v.role is Role.OUTPUT or v.output


def causality(v: Variable) -> str:
    """FMI causality."""
    if v.role in (Role.PARAMETER, Role.INPUT):
        return str(v.role.value)
    return "output" if is_output(v) else "local"


def variability(model: Model, v: Variable) -> str:
    """FMI variability."""
    if v.role is Role.PARAMETER:
        return "fixed" if v.fixed else "tunable"
    stepwise = v.sampled or v.boolean or (v.role is Role.OUTPUT and not model.n_continuous)
    return "discrete" if stepwise else "continuous"


def start_text(v: Variable) -> str:
    """Start value, exact to the last bit."""
    if v.boolean:
        return "true" if v.start else "false"
    return repr(int(v.start)) if v.integer else repr(float(v.start))


def used_units(model: Model) -> list[str]:
    """Units of all shown variables, each once, sorted."""
    return sorted({v.unit for _, v in fmi_variables(model) if not (v.integer or v.boolean)})


def describe(model: Model, flavour: Flavour, token: str) -> bytes:
    """Write modelDescription.xml of FMI 2.0; `token` is the GUID."""
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
    _co_simulation(root, model, flavour)
    _unit_definitions(root, model)
    _type_definitions(root, model)
    _log_categories(root)
    ET.SubElement(root, "DefaultExperiment", startTime="0.0", stopTime="10.0", stepSize=repr(STEP_SIZE))
    annotations = ET.SubElement(root, "VendorAnnotations")
    add_coupling_facts(ET.SubElement(annotations, "Tool", name=TOOL), model)
    _model_variables(root, model)
    _model_structure(root, model)
    return document(root)


def document(root: ET.Element) -> bytes:
    """Serialise with two blanks of indentation."""
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def add_coupling_facts(parent: ET.Element, model: Model) -> None:
    """Write what the master's delay ledger asks of an FMU: which inputs reach an output, and own delays."""
    for name, inputs in influences(model).items():
        ET.SubElement(parent, "Influence", output=name, inputs=" ".join(inputs))
    for delay in model.delays:
        _add_delay(parent, delay)


def _add_delay(parent: ET.Element, delay: Delay) -> None:
    element = ET.SubElement(parent, "Delay", input=delay.input, kind=delay.kind, reason=delay.reason)
    element.set("seconds", str(delay.seconds))
    if isinstance(delay.steps, float | int):
        element.set("steps", str(delay.steps))
        return
    element.set("by", delay.by or "")
    for item, steps in delay.steps.items():
        ET.SubElement(element, "When", item=item, steps=str(steps))


def type_name(v: Variable) -> str:
    """Name of the type definition of an enumeration."""
    assert v.items is not None
    return v.items.__name__


def _co_simulation(root: ET.Element, model: Model, flavour: Flavour) -> None:
    ET.SubElement(
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


def _unit_definitions(root: ET.Element, model: Model) -> None:
    units = ET.SubElement(root, "UnitDefinitions")
    for name in used_units(model):
        unit = ET.SubElement(units, "Unit", name=name)
        exponents = si_exponents(name)
        ET.SubElement(unit, "BaseUnit", {b: str(exponents[b]) for b in BASE_UNITS if b in exponents})
        if name in DISPLAY_UNITS:
            shown, factor = DISPLAY_UNITS[name]
            ET.SubElement(unit, "DisplayUnit", name=shown, factor=repr(factor))


def _type_definitions(root: ET.Element, model: Model) -> None:
    enumerations = {type_name(v): v for v in model.all_variables if v.items is not None}
    if not enumerations:
        return
    types = ET.SubElement(root, "TypeDefinitions")
    for name, v in enumerations.items():
        simple = ET.SubElement(ET.SubElement(types, "SimpleType", name=name), "Enumeration")
        for item in v.items or ():
            ET.SubElement(simple, "Item", name=item.name, value=str(item.value))


def _log_categories(root: ET.Element) -> None:
    categories = ET.SubElement(root, "LogCategories")
    for name in ("logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal", "logAll"):
        ET.SubElement(categories, "Category", name=name)


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
        typed = ET.SubElement(scalar, "Integer", _bounds(v, int))
    else:
        typed = ET.SubElement(scalar, "Real", {"unit": v.unit, **_bounds(v, float)})
    if with_start:
        typed.set("start", start_text(v))


def _bounds(v: Variable, number: type[int] | type[float]) -> dict[str, str]:
    low = v.above if v.minimum is None else v.minimum
    pairs = (("min", low), ("max", v.maximum), ("nominal", v.nominal))
    return {key: repr(number(value)) for key, value in pairs if value is not None}


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
