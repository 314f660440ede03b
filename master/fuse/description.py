"""modelDescription.xml of a fused FMU, of FMI 2.0 and of FMI 3.0."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import partial
from xml.etree import ElementTree as ET

from fmu_sources.export.facts import DATE, TOOL, add_log_categories, document
from fmu_sources.export.units import DISPLAY_UNITS
from master.fmi.description import Variable

from .layout import Fused, FusedVariable

_STRUCTURED = re.compile(r"[A-Za-z_]\w*(\[\d+(,\d+)*\])?(\.[A-Za-z_]\w*(\[\d+(,\d+)*\])?)*", re.ASCII)
_FMI2_TAGS = {"REAL": "Real", "INTEGER": "Integer", "ENUMERATION": "Enumeration", "BOOLEAN": "Boolean"}
_FMI3_TAGS = {"REAL": "Float64", "INTEGER": "Int32", "ENUMERATION": "Enumeration", "BOOLEAN": "Boolean"}


def describe_fmi2(fused: Fused, token: str, c_files: Sequence[str]) -> bytes:
    """Write modelDescription.xml of FMI 2.0; `token` is the GUID, `c_files` are in `sources/`."""
    root = ET.Element("fmiModelDescription", fmiVersion="2.0", modelName=fused.name, guid=token)
    _about(root, fused)
    root.set("numberOfEventIndicators", "0")
    element = ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=fused.identifier,
        needsExecutionTool=_needs_tool(fused),
        canHandleVariableCommunicationStepSize="false",
        canInterpolateInputs="false",
        canBeInstantiatedOnlyOncePerProcess=_is_alone(fused),
        canNotUseMemoryManagementFunctions="true",
        canGetAndSetFMUstate=_truth(fused.saves_state),
        canSerializeFMUstate=_truth(not fused.has_foreign),
        providesDirectionalDerivative="false",
    )
    if c_files:
        files = ET.SubElement(element, "SourceFiles")
        for name in c_files:
            ET.SubElement(files, "File", name=name)
    _units(root, fused)
    types = _types(fused)
    if types:
        definitions = ET.SubElement(root, "TypeDefinitions")
        for items, name in types.items():
            simple = ET.SubElement(ET.SubElement(definitions, "SimpleType", name=name), "Enumeration")
            _items(simple, items)
    add_log_categories(root)
    _experiment(root, fused)
    variables = ET.SubElement(root, "ModelVariables")
    for reference, v in _shown(fused):
        element = ET.SubElement(variables, "ScalarVariable", _common(v, reference))
        typed = ET.SubElement(element, _FMI2_TAGS[v.row.type], _typed(v, types))
        if v.has_start:
            typed.set("start", v.start_text)
    place = {v.name: i for i, (_, v) in enumerate(_shown(fused), start=1)}
    structure = ET.SubElement(root, "ModelStructure")
    outputs = ET.SubElement(structure, "Outputs")
    for v in _outputs(fused):
        ET.SubElement(outputs, "Unknown", index=str(place[v.name]), dependencies="")
    calculated = [v for v in _outputs(fused) if not v.has_start]
    if calculated:
        unknowns = ET.SubElement(structure, "InitialUnknowns")
        for v in calculated:
            ET.SubElement(unknowns, "Unknown", index=str(place[v.name]))
    return document(root)


def describe_fmi3(fused: Fused, token: str, c_files: Sequence[str]) -> bytes:
    """Write modelDescription.xml of FMI 3.0; `token` is the instantiation token."""
    root = ET.Element("fmiModelDescription", fmiVersion="3.0", modelName=fused.name, instantiationToken=token)
    _about(root, fused)
    ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=fused.identifier,
        needsExecutionTool=_needs_tool(fused),
        canHandleVariableCommunicationStepSize="true",
        fixedInternalStepSize=repr(fused.grid.step_size),
        canBeInstantiatedOnlyOncePerProcess=_is_alone(fused),
        canGetAndSetFMUState=_truth(fused.saves_state),
        canSerializeFMUState=_truth(not fused.has_foreign),
        providesDirectionalDerivatives="false",
        hasEventMode="false",
    )
    _units(root, fused)
    types = _types(fused)
    if types:
        definitions = ET.SubElement(root, "TypeDefinitions")
        for items, name in types.items():
            _items(ET.SubElement(definitions, "EnumerationType", name=name), items)
    add_log_categories(root)
    _experiment(root, fused)
    variables = ET.SubElement(root, "ModelVariables")
    ET.SubElement(
        variables,
        "Float64",
        name="time",
        valueReference=str(len(fused.variables)),
        causality="independent",
        variability="continuous",
        description="simulation time",
    )
    for reference, v in _shown(fused):
        attributes = _common(v, reference) | _typed(v, types)
        element = ET.SubElement(variables, _FMI3_TAGS[v.row.type], attributes)
        if v.has_start:
            element.set("start", v.start_text)
    structure = ET.SubElement(root, "ModelStructure")
    for v in _outputs(fused):
        reference_of = str(fused.reference_of[v.name])
        ET.SubElement(structure, "Output", valueReference=reference_of, dependencies="")
    for v in _outputs(fused):
        if not v.has_start:
            ET.SubElement(structure, "InitialUnknown", valueReference=str(fused.reference_of[v.name]))
    return document(root)


def _truth(is_true: bool) -> str:
    return "true" if is_true else "false"


def _is_alone(fused: Fused) -> str:
    """Whether an FMU that is carried along allows one instance a process."""
    return _truth(any(i.model.is_foreign and i.description.once_per_process for i in fused.inners.values()))


def _needs_tool(fused: Fused) -> str:
    """Whether an FMU that is carried along needs its tool."""
    needs = any(i.model.is_foreign and i.description.needs_execution_tool for i in fused.inners.values())
    return _truth(needs)


def _about(root: ET.Element, fused: Fused) -> None:
    if fused.description:
        root.set("description", fused.description)
    root.set("generationTool", f"{TOOL} (system)")
    root.set("generationDateAndTime", DATE)
    is_structured = all(_STRUCTURED.fullmatch(v.name) for _, v in _shown(fused))
    root.set("variableNamingConvention", "structured" if is_structured else "flat")


def _experiment(root: ET.Element, fused: Fused) -> None:
    grid = fused.grid
    ET.SubElement(
        root,
        "DefaultExperiment",
        startTime=repr(grid.t0),
        stopTime=repr(grid.time(grid.n_ticks)),
        stepSize=repr(grid.step_size),
    )


def _shown(fused: Fused) -> list[tuple[int, FusedVariable]]:
    """Variables that FMI shows, with their value references."""
    return [(i, v) for i, v in enumerate(fused.variables) if v.described is not None]


def _outputs(fused: Fused) -> list[FusedVariable]:
    return [v for _, v in _shown(fused) if v.causality == "output"]


def _common(v: FusedVariable, reference: int) -> dict[str, str]:
    said = _said(v)
    attributes = {"name": v.name, "valueReference": str(reference)}
    if said.description:
        attributes["description"] = said.description
    is_stepwise = v.row.type != "REAL" and said.variability == "continuous"  # FMI allows that of reals alone
    variability = "discrete" if is_stepwise else said.variability
    attributes |= {"causality": v.causality, "variability": variability}
    if v.causality != "input":
        attributes["initial"] = "exact" if v.has_start else "calculated"
    return attributes


def _typed(v: FusedVariable, types: Mapping[tuple[tuple[str, int], ...], str]) -> dict[str, str]:
    """Unit or declared type, and bounds."""
    said = _said(v)
    if v.row.type == "BOOLEAN":
        return {}
    if v.row.type == "ENUMERATION":
        return {"declaredType": types[tuple(said.items.items())]}
    number = partial(_number, is_real=v.row.type == "REAL")
    attributes = {"unit": said.unit.name} if said.unit is not None and v.row.type == "REAL" else {}
    bounds = {"min": said.minimum, "max": said.maximum}
    if v.row.type == "REAL":
        bounds["nominal"] = said.nominal
    return attributes | {key: number(value) for key, value in bounds.items() if value is not None}


def _number(value: float, *, is_real: bool) -> str:
    return repr(float(value)) if is_real else str(int(value))


def _said(v: FusedVariable) -> Variable:
    assert v.described is not None, "hidden variables are not written"
    return v.described


def _types(fused: Fused) -> dict[tuple[tuple[str, int], ...], str]:
    """Names of enumerations by their items; no variable has such a name."""
    found: dict[tuple[tuple[str, int], ...], str] = {}
    for _, v in _shown(fused):
        if v.row.type == "ENUMERATION":
            found.setdefault(tuple(_said(v).items.items()), f"items of {v.name}")
    return found


def _items(parent: ET.Element, items: Sequence[tuple[str, int]]) -> None:
    for name, value in items:
        ET.SubElement(parent, "Item", name=name, value=str(value))


def _units(root: ET.Element, fused: Fused) -> None:
    found = fused.units
    if not found:
        return
    units = ET.SubElement(root, "UnitDefinitions")
    for name, unit in sorted(found.items()):
        element = ET.SubElement(units, "Unit", name=name)
        if not unit.defined:
            continue
        base = {key: str(exponent) for key, exponent in unit.exponents.items()}
        base |= {"factor": repr(unit.factor)} if unit.factor != 1.0 else {}
        base |= {"offset": repr(unit.offset)} if unit.offset != 0.0 else {}
        ET.SubElement(element, "BaseUnit", base)
        if name in DISPLAY_UNITS:
            display, factor = DISPLAY_UNITS[name]
            ET.SubElement(element, "DisplayUnit", name=display, factor=repr(factor))
