"""
A checked system as an SSP 1.0 archive.

FMUs and parameter values stand in `resources/`; what SSP has no word for (order, delays, rates, what a
run is judged by) stands in an annotation of the system as JSON. The root system has no connectors.
Source: System Structure and Parameterization 1.0, Modelica Association (2019).
"""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any, Protocol
from xml.etree import ElementTree as ET

from master.fmi.description import Kind, Variable
from master.system.config import Config
from master.system.graph import Instance, System, Wire

from .names import COUPLING, SSC, SSD, SSV, STRUCTURE, ssc, ssd, ssv

PARAMETER_SET = "initialValues"  # one name for all FMUs: tools choose a set by its name
_DATE = (2026, 1, 1, 0, 0, 0)


class Experiment(Protocol):
    """What an archive holds of a prepared system."""

    @property
    def config(self) -> Config: ...

    @property
    def variant(self) -> str | None: ...

    @property
    def system(self) -> System: ...


def write_ssp(experiment: Experiment, path: Path) -> Path:
    """Write the archive."""
    for prefix, uri in (("ssc", SSC), ("ssd", SSD), ("ssv", SSV)):
        ET.register_namespace(prefix, uri)
    instances = experiment.system.instances
    contents = {STRUCTURE: _document(_structure(experiment))}
    for name, instance in instances.items():
        contents[f"resources/{name}.fmu"] = instance.description.path.read_bytes()
        contents[f"resources/{name}.ssv"] = _document(_parameter_set(instance))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(_pack(contents))
    return path


def _pack(contents: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in contents.items():
            archive.writestr(zipfile.ZipInfo(name, _DATE), content, zipfile.ZIP_DEFLATED)
    return buffer.getvalue()


def _document(root: ET.Element) -> bytes:
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def _structure(experiment: Experiment) -> ET.Element:
    config = experiment.config
    root = ET.Element(ssd("SystemStructureDescription"), version="1.0", name=config.name)
    system = ET.SubElement(root, ssd("System"), name=config.name, description=config.description)
    elements = ET.SubElement(system, ssd("Elements"))
    for instance in experiment.system.instances.values():
        _component(elements, instance)
    connections = ET.SubElement(system, ssd("Connections"))
    for wire in experiment.system.wires:
        _connection(connections, wire)
    annotations = ET.SubElement(system, ssd("Annotations"))
    annotation = ET.SubElement(annotations, ssc("Annotation"), type=COUPLING)
    ET.SubElement(annotation, "Coupling").text = json.dumps(coupling(experiment), sort_keys=True)
    _units(root, experiment)
    times = {"startTime": repr(config.start_time), "stopTime": repr(config.stop_time)}
    ET.SubElement(root, ssd("DefaultExperiment"), times)
    return root


def coupling(experiment: Experiment) -> dict[str, Any]:
    """What SSP has no word for, as data of the YAML form."""
    kept = experiment.config.model_dump(by_alias=True, exclude_unset=True)
    return {
        "variant": experiment.variant,
        "every": {name: i.every for name, i in experiment.system.instances.items() if i.every > 1},
        "step_size": experiment.config.step_size,
        **{
            key: kept[key]
            for key in ("description", "coupling", "compare", "limits", "events")
            if key in kept
        },
        "connections": [c.model_dump(by_alias=True) for c in experiment.config.connections],
    }


def _component(elements: ET.Element, instance: Instance) -> None:
    component = ET.SubElement(
        elements,
        ssd("Component"),
        name=instance.name,
        type="application/x-fmu-sharedlibrary",
        source=f"resources/{instance.name}.fmu",
        implementation="CoSimulation",
    )
    connectors = ET.SubElement(component, ssd("Connectors"))
    for v in instance.description.variables:
        if v.causality in ("input", "output") and v.kind is not Kind.STRING:
            connector = ET.SubElement(connectors, ssd("Connector"), name=v.name, kind=v.causality)
            _type(connector, v)
    bindings = ET.SubElement(component, ssd("ParameterBindings"))
    ET.SubElement(bindings, ssd("ParameterBinding"), source=f"resources/{instance.name}.ssv")


def _type(parent: ET.Element, v: Variable) -> None:
    tag = {Kind.REAL: "Real", Kind.BOOLEAN: "Boolean"}.get(v.kind, "Integer")
    element = ET.SubElement(parent, ssc(tag))
    if v.unit is not None and v.kind is Kind.REAL:
        element.set("unit", v.unit.name)


def _connection(connections: ET.Element, wire: Wire) -> None:
    connection = ET.SubElement(
        connections,
        ssd("Connection"),
        startElement=wire.source.instance,
        startConnector=wire.source.variable.name,
        endElement=wire.target.instance,
        endConnector=wire.target.variable.name,
    )
    if not wire.conversion.is_identity:
        connection.set("suppressUnitConversion", "true")
        factor, offset = repr(wire.conversion.factor), repr(wire.conversion.offset)
        ET.SubElement(connection, ssc("LinearTransformation"), factor=factor, offset=offset)


def _units(root: ET.Element, experiment: Experiment) -> None:
    found = {
        v.unit.name: v.unit
        for i in experiment.system.instances.values()
        for v in i.description.variables
        if v.unit is not None and v.unit.defined and v.causality in ("input", "output")
    }
    if not found:
        return
    units = ET.SubElement(root, ssd("Units"))
    for name in sorted(found):
        unit = found[name]
        base = {key: str(exponent) for key, exponent in unit.exponents.items()}
        if unit.factor != 1.0 or unit.offset != 0.0:
            base |= {"factor": repr(unit.factor), "offset": repr(unit.offset)}
        ET.SubElement(ET.SubElement(units, ssc("Unit"), name=name), ssc("BaseUnit"), base)


def _parameter_set(instance: Instance) -> ET.Element:
    root = ET.Element(ssv("ParameterSet"), version="1.0", name=PARAMETER_SET)
    parameters = ET.SubElement(root, ssv("Parameters"))
    for key, value in instance.start.items():
        variable = instance.description.by_name[key]
        parameter = ET.SubElement(parameters, ssv("Parameter"), name=key)
        tag, text = _value(variable, value)
        ET.SubElement(parameter, ssv(tag), value=text)
    return root


def _value(variable: Variable, value: float | str) -> tuple[str, str]:
    if isinstance(value, str):
        return "String", value
    if variable.kind is Kind.BOOLEAN:
        return "Boolean", "true" if value else "false"
    if variable.kind is Kind.INTEGER:
        return "Integer", str(int(value))
    return "Real", repr(value)
