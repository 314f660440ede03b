"""
A checked system as an SSP 1.0 archive.

FMUs and parameter values are in `resources/`; what SSP has no word for (order, delays, rates, what a run is
judged by) is in an annotation of the system as JSON. The root system has the connectors that the
configuration names, and no others, which some tools refuse. Conversions of units are written out as linear
transformations, as few tools convert units.
Source: System Structure and Parameterization 1.0, Modelica Association (2019).
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from urllib.parse import quote

from lxml import etree

from master.errors import ConfigError
from master.fmi.description import Kind, Variable
from master.fmi.units import Unit
from master.recording.whole_file import write_whole
from master.system.graph import Instance, System, Wire

from .annotation import write_coupling
from .names import COUPLING, COUPLING_ELEMENT, FMU, PREFIXES, STRUCTURE, TABLES, ssc, ssd, ssv
from .packed_recordings import PackedRecordings, pack_recordings
from .prepared import PreparedSystem

PARAMETER_SET = "initialValues"  # one name for all FMUs: tools choose a set by its name
_DATE = (2026, 1, 1, 0, 0, 0)
_INT32 = range(-(2**31), 2**31)
_NOT_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write_ssp(experiment: PreparedSystem, path: Path) -> Path:
    """
    Write the archive.

    Raises:
        ConfigError: With every part of the system that an SSP cannot hold, or if the file cannot be written.
    """
    problems = list(_faults(experiment))
    if problems:
        raise ConfigError(problems)
    files = _files(experiment.system)
    taken = [f"resources/{file}{suffix}" for file in files.values() for suffix in (".fmu", ".ssv")]
    recordings = pack_recordings(experiment, [STRUCTURE, *taken])
    owner = _owner(experiment, recordings)
    unsaid: dict[str, dict[str, float | str]] = {}
    contents: dict[str, bytes] = {}
    for name, instance in experiment.system.instances.items():
        said = {key: value for key, value in instance.start.items() if _can_say(instance, key, value)}
        contents[f"resources/{files[name]}.fmu"] = instance.description.path.read_bytes()
        contents[f"resources/{files[name]}.ssv"] = _document(_parameter_set(instance, said))
        left = {key: value for key, value in instance.start.items() if key not in said}
        if left:
            unsaid[name] = left
    contents |= {recordings.members[name]: content for name, content in recordings.contents.items()}
    structure = _document(_structure(experiment, files, recordings, owner, unsaid))
    try:
        write_whole(path, _pack({STRUCTURE: structure, **contents}))
    except (OSError, ValueError) as error:
        raise ConfigError([f"{path}: cannot be written, got {error}"]) from None
    return path


def _pack(contents: Mapping[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in contents.items():
            archive.writestr(zipfile.ZipInfo(name, _DATE), content, zipfile.ZIP_DEFLATED)
    return buffer.getvalue()


def _document(root: etree._Element) -> bytes:
    text: bytes = etree.tostring(root, encoding="UTF-8", xml_declaration=True, pretty_print=True)
    return text


def _faults(experiment: PreparedSystem) -> Iterator[str]:
    """What no SSP can say: characters that XML does not have, a map and a factor on one wire."""
    config, system = experiment.config, experiment.system
    names = [config.name, config.description]
    for name, instance in system.instances.items():
        names += [name, *(v.name for v in instance.description.variables)]
    for description in system.connectors.values():
        names += [v.name for v in description.variables]
    for name in names:
        if _NOT_XML.search(name):
            yield f"{name!r}: cannot be written as SSP, got a character that XML does not have"
    for wire in (*system.wires, *system.inlets, *system.outlets):
        ends = f"{wire.source.name} -> {wire.target.name}"
        conversion = wire.conversion
        kinds = {wire.source.variable.kind, wire.target.variable.kind}
        if not conversion.is_affine and (conversion.factor, conversion.offset) != (1.0, 0.0):
            yield f"{ends}: cannot be written as SSP, got a map with a factor or an offset, expected one"
        if wire.source.variable.causality == "local":
            yield f"{ends}: cannot be written as SSP 1.0, got a local variable, expected an output"
        if not conversion.is_affine and len(kinds) > 1:
            yield f"{ends}: cannot be written as SSP, got a map between different types, expected one type"


def _files(system: System) -> dict[str, str]:
    """Names of the files of each FMU: plain characters, each once also where letters have no case."""
    found: dict[str, str] = {}
    taken: set[str] = set()
    for name in system.instances:
        wanted = re.sub(r"[^A-Za-z0-9_-]", "_", name)[:80]
        file = wanted
        n = 2
        while file.lower() in taken:
            file = f"{wanted}_{n}"
            n += 1
        taken.add(file.lower())
        found[name] = file
    return found


def _owner(experiment: PreparedSystem, recordings: PackedRecordings) -> str:
    """
    Name of the system: that of its own connectors, if it has any.

    Raises:
        ConfigError: If connectors have several owners that are no recordings.
    """
    owners = [name for name in experiment.system.connectors if name not in recordings.components]
    if len(owners) > 1:
        got = " and ".join(map(repr, owners))
        raise ConfigError(
            [f"connectors: cannot be written as SSP, got {got}, expected one name of the system"]
        )
    return owners[0] if owners else experiment.config.name


def _structure(
    experiment: PreparedSystem,
    files: Mapping[str, str],
    recordings: PackedRecordings,
    owner: str,
    unsaid: Mapping[str, Mapping[str, float | str]],
) -> etree._Element:
    config = experiment.config
    coupling = write_coupling(experiment, unsaid, recordings)
    units = _units_of(experiment.system)
    root = etree.Element(
        ssd("SystemStructureDescription"),
        version="1.0",
        name=config.name,
        nsmap={key: PREFIXES[key] for key in ("ssd", "ssc", "ssv")},
    )
    system = etree.SubElement(root, ssd("System"), name=owner, description=config.description)
    own = experiment.system.connectors.get(owner)
    if own is not None:
        _connectors(system, own.variables, units)
    elements = etree.SubElement(system, ssd("Elements"))
    for name, instance in experiment.system.instances.items():
        _component(elements, instance, _exchanged(experiment.system, instance), files[name], units)
    for name, file in recordings.components.items():
        source = quote(recordings.members[file])
        component = etree.SubElement(elements, ssd("Component"), name=name, type=TABLES[0], source=source)
        _connectors(component, experiment.system.connectors[name].variables, units, kind="output")
    wires = (*experiment.system.wires, *experiment.system.inlets, *experiment.system.outlets)
    if wires:
        connections = etree.SubElement(system, ssd("Connections"))
        for wire in wires:
            _connection(connections, wire, owner)
    annotations = etree.SubElement(system, ssd("Annotations"))
    annotation = etree.SubElement(annotations, ssc("Annotation"), type=COUPLING)
    etree.SubElement(annotation, COUPLING_ELEMENT, nsmap={None: COUPLING}).text = coupling
    _write_units(root, units)
    times = {"startTime": repr(config.start_time), "stopTime": repr(config.stop_time)}
    etree.SubElement(root, ssd("DefaultExperiment"), times)
    return root


def _exchanged(system: System, instance: Instance) -> list[Variable]:
    """Variables of an FMU that are connectors: inputs, outputs, and what connectors of the system reach."""
    ports = [*(w.target for w in system.inlets), *(w.source for w in system.outlets)]
    reached = {port.variable.name for port in ports if port.instance == instance.name}
    return [
        v
        for v in instance.description.variables
        if v.name in reached or (v.causality in ("input", "output") and v.kind is not Kind.STRING)
    ]


def _component(
    elements: etree._Element,
    instance: Instance,
    exchanged: Sequence[Variable],
    file: str,
    units: Mapping[str, Unit],
) -> None:
    source = quote(f"resources/{file}")
    component = etree.SubElement(
        elements,
        ssd("Component"),
        name=instance.name,
        type=FMU,
        source=f"{source}.fmu",
        implementation="CoSimulation",
    )
    _connectors(component, exchanged, units)
    bindings = etree.SubElement(component, ssd("ParameterBindings"))
    etree.SubElement(bindings, ssd("ParameterBinding"), source=f"{source}.ssv")


def _connectors(
    parent: etree._Element, variables: Sequence[Variable], units: Mapping[str, Unit], kind: str | None = None
) -> None:
    if not variables:
        return
    connectors = etree.SubElement(parent, ssd("Connectors"))
    for v in variables:
        connector = etree.SubElement(connectors, ssd("Connector"), name=v.name, kind=kind or v.causality)
        _type(connector, v, units)


def _type(parent: etree._Element, v: Variable, units: Mapping[str, Unit]) -> None:
    tag = {Kind.REAL: "Real", Kind.BOOLEAN: "Boolean", Kind.STRING: "String"}.get(v.kind, "Integer")
    element = etree.SubElement(parent, ssc(tag))
    if v.kind is Kind.REAL and v.unit is not None and units.get(v.unit.name) == v.unit:
        element.set("unit", v.unit.name)


def _connection(connections: etree._Element, wire: Wire, owner: str) -> None:
    connection = etree.SubElement(connections, ssd("Connection"))
    for end, port in (("start", wire.source), ("end", wire.target)):
        if port.instance != owner:
            connection.set(f"{end}Element", port.instance)
        connection.set(f"{end}Connector", port.variable.name)
    conversion = wire.conversion
    units = [wire.source.variable.unit, wire.target.variable.unit]
    if not conversion.is_identity or units[0] != units[1]:
        connection.set("suppressUnitConversion", "true")
    if not conversion.is_affine:
        kind = "Boolean" if wire.source.variable.kind is Kind.BOOLEAN else "Integer"
        mapping = etree.SubElement(connection, ssc(f"{kind}MappingTransformation"))
        for source, target in conversion.table:
            texts = [_number(kind, value) for value in (source, target)]
            etree.SubElement(mapping, ssc("MapEntry"), source=texts[0], target=texts[1])
    elif not conversion.is_identity:
        factor, offset = repr(conversion.factor), repr(conversion.offset)
        etree.SubElement(connection, ssc("LinearTransformation"), factor=factor, offset=offset)


def _number(kind: str, value: float) -> str:
    if kind == "Boolean":
        return "true" if value else "false"
    return str(int(value))


def _units_of(system: System) -> dict[str, Unit]:
    """Units of connectors by name; of two that share a name the first, the other is left to its FMU."""
    found: dict[str, Unit] = {}
    for instance in system.instances.values():
        for v in _exchanged(system, instance):
            _add_unit(found, v)
    for description in system.connectors.values():
        for v in description.variables:
            _add_unit(found, v)
    return found


def _add_unit(found: dict[str, Unit], v: Variable) -> None:
    if v.unit is not None and v.unit.defined:
        found.setdefault(v.unit.name, v.unit)


def _write_units(root: etree._Element, found: Mapping[str, Unit]) -> None:
    if not found:
        return
    units = etree.SubElement(root, ssd("Units"))
    for name in sorted(found):
        unit = found[name]
        base = {key: str(exponent) for key, exponent in unit.exponents.items()}
        if unit.factor != 1.0 or unit.offset != 0.0:
            base |= {"factor": repr(unit.factor), "offset": repr(unit.offset)}
        etree.SubElement(etree.SubElement(units, ssc("Unit"), name=name), ssc("BaseUnit"), base)


def _can_say(instance: Instance, key: str, value: float | str) -> bool:
    """Whether a parameter set can hold a value: XML lacks some characters, its integers have 32 bits."""
    variable = instance.description.by_name[key]
    if isinstance(value, str):
        return not _NOT_XML.search(value) and "\r" not in value
    return variable.kind is not Kind.INTEGER or int(value) in _INT32


def _parameter_set(instance: Instance, start: Mapping[str, float | str]) -> etree._Element:
    root = etree.Element(
        ssv("ParameterSet"), version="1.0", name=PARAMETER_SET, nsmap={"ssv": PREFIXES["ssv"]}
    )
    parameters = etree.SubElement(root, ssv("Parameters"))
    for key, value in start.items():
        variable = instance.description.by_name[key]
        parameter = etree.SubElement(parameters, ssv("Parameter"), name=key)
        tag, text = _value(variable, value)
        etree.SubElement(parameter, ssv(tag), value=text)
    return root


def _value(variable: Variable, value: float | str) -> tuple[str, str]:
    if isinstance(value, str):
        return "String", value
    if variable.kind is Kind.BOOLEAN:
        return "Boolean", "true" if value else "false"
    if variable.kind is Kind.INTEGER:
        names = [name for name, number in variable.items.items() if number == value]
        return ("Enumeration", names[0]) if names else ("Integer", str(int(value)))
    return "Real", repr(value)
