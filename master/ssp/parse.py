"""From the files of a package to a `Structure`: the XML checked, all that it refers to read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

from master.errors import ConfigError, expected
from master.fmi.description import Description
from master.fmi.description_reader import read_description

from . import grammar
from .grammar import everywhere
from .markup import Node, Rule, boolean, double, integer, read_xml
from .names import (
    COUPLING,
    COUPLING_ELEMENT,
    DEFINITION,
    FMU,
    PACKAGE,
    PARAMETER_MAPPING,
    PARAMETER_SET,
    SIGNAL_DICTIONARY,
    STRUCTURE,
    TABLES,
    ssb,
    ssc,
    ssd,
    ssm,
    ssv,
)
from .package import Archive, Package, locate
from .parse_values import read_parameters, read_renamings, read_scope, read_transformation, read_type
from .structure import (
    Annotation,
    Binding,
    Component,
    Connector,
    DataType,
    Dictionary,
    End,
    Given,
    Link,
    Recording,
    Reference,
    Renaming,
    Scope,
    Structure,
    SubSystem,
)
from .table_header import time_column

MOST_NESTED = 32  # files within files

T = TypeVar("T")

Element = Component | Recording | SubSystem | Reference


@dataclass
class _Reading:
    """What reading a structure gathers: faults, notes, FMUs by their file."""

    folder: Path
    label: str = ""
    problems: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    descriptions: dict[Path, Description] = field(default_factory=dict)
    other_annotations: set[str] = field(default_factory=set)


@dataclass(frozen=True)
class _File:
    """An open structure file: where relative URIs start, what is defined, what encloses it."""

    package: Package
    member: str
    scope: Scope
    root: Node
    enclosing: tuple[str, ...]

    @property
    def base(self) -> str:
        """Folder of the file within its package."""
        folder, slash, _ = self.member.rpartition("/")
        return folder + slash


def parse_structure(package: Package, member: str, folder: Path) -> Structure:
    """
    Read a structure file with all that it refers to.

    Args:
        package: Where its files are.
        member: The file.
        folder: Where FMUs may be unpacked.

    Raises:
        ConfigError: With every fault.
    """
    reading = _Reading(folder, package.label)
    file = _open(reading, package, member, ())
    if file is None:
        raise ConfigError(reading.problems)
    system = _root_system(reading, file)
    experiment = file.root.child(ssd("DefaultExperiment"))
    coupling = _coupling(reading, file.root)
    if reading.problems or system is None:
        raise ConfigError(dict.fromkeys(reading.problems))
    described = file.root.child(ssd("System"))
    return Structure(
        name=file.root.text("name"),
        description="" if described is None else described.text("description"),
        system=system,
        start_time=_time(experiment, "startTime"),
        stop_time=_time(experiment, "stopTime"),
        times_where=file.root.where if experiment is None else experiment.where,
        coupling=coupling,
        annotations=tuple(sorted(reading.other_annotations)),
        notes=tuple(reading.notes),
    )


def _time(experiment: Node | None, name: str) -> float | None:
    text = None if experiment is None else experiment.get(name)
    return None if text is None else double(text)


def _open(reading: _Reading, package: Package, member: str, enclosing: tuple[str, ...]) -> _File | None:
    name = package.name_of(member)
    if name in enclosing:
        reading.problems.append(f"{name}: contains itself, expected systems that end")
        return None
    if len(enclosing) > MOST_NESTED:
        reading.problems.append(f"{name}: nested too deeply, expected at most {MOST_NESTED} files")
        return None
    root = _xml(reading, package, member, ssd("SystemStructureDescription"), grammar.STRUCTURE)
    if root is None:
        return None
    for annotation in root.element.iter(ssc("Annotation")):
        if annotation.get("type") != COUPLING:
            reading.other_annotations.add(annotation.get("type") or "")
    return _File(package, member, read_scope(root, reading.problems), root, (*enclosing, name))


def _xml(
    reading: _Reading, package: Package, member: str, root: str, rules: Mapping[str, Rule]
) -> Node | None:
    try:
        return read_xml(package.read(member), package.name_of(member), root, rules)
    except ConfigError as error:
        reading.problems += error.problems
        return None


def _coupling(reading: _Reading, root: Node) -> Annotation | None:
    """Find what this project's export added to the system."""
    system = root.child(ssd("System"))
    if system is None:
        return None
    found = [
        annotation
        for holder in system.children()
        if holder.element.tag in everywhere("Annotations")
        for annotation in holder.children(ssc("Annotation"))
        if annotation.get("type") == COUPLING
    ]
    if not found:
        return None
    if len(found) > 1:
        reading.problems.append(f"{found[1].where}: twice, expected one annotation {COUPLING}")
    inner = next((one.element for one in found[0].children()), None)
    if inner is None or inner.tag not in (COUPLING_ELEMENT, "Coupling"):
        reading.problems.append(f"{found[0].where}: not understood, expected an element Coupling")
        return None
    return Annotation(inner.text or "", found[0].where)


def _root_system(reading: _Reading, file: _File) -> SubSystem | None:
    node = file.root.child(ssd("System"))
    if node is None:
        reading.problems.append(f"{file.root.where}: System is missing, expected one")
        return None
    return _system(reading, file, node)


def _system(reading: _Reading, file: _File, node: Node) -> SubSystem:
    elements: dict[str, Element] = {}
    for one in node.children(f"{ssd('Elements')}/*"):
        _add(elements, one, _element(reading, file, one), "element", reading)
    dictionaries: dict[str, Dictionary] = {}
    for one in node.children(f"{ssd('SignalDictionaries')}/{ssd('SignalDictionary')}"):
        _add(dictionaries, one, _dictionary(reading, file, one), "dictionary", reading)
    return SubSystem(
        name=node.text("name"),
        connectors=_connectors(reading, file, node),
        bindings=_bindings(reading, file, node, None),
        elements=elements,
        links=tuple(
            _link(reading, one) for one in node.children(f"{ssd('Connections')}/{ssd('Connection')}")
        ),
        dictionaries=dictionaries,
        where=node.where,
    )


def _add(found: dict[str, T], node: Node, made: T | None, what: str, reading: _Reading) -> None:
    name = node.text("name")
    if name in found:
        reading.problems.append(f"{node.where}: twice in its system, expected one {what} of a name")
    if made is not None:
        found[name] = made


def _element(reading: _Reading, file: _File, node: Node) -> Element | None:
    if node.tag == "System":
        return _system(reading, file, node)
    if node.tag == "SignalDictionaryReference":
        connectors = _connectors(reading, file, node)
        if node.child(ssd("ParameterBindings")) is not None:
            reading.problems.append(
                f"{node.where}: values for a dictionary are not understood, expected none"
            )
        return Reference(node.text("name"), node.text("dictionary"), connectors, node.where)
    kind = node.get("type") or FMU
    if kind == FMU:
        return _fmu(reading, file, node)
    if kind in (DEFINITION, PACKAGE):
        return _described_elsewhere(reading, file, node, kind)
    if kind in TABLES:
        return _recording(reading, file, node, kind)
    known = expected(kind, (FMU, DEFINITION, PACKAGE, *TABLES))
    reading.problems.append(
        f"{node.where}: a component of this type cannot be stepped, got {kind!r}, {known}"
    )
    return None


def _fmu(reading: _Reading, file: _File, node: Node) -> Component | None:
    implementation = node.get("implementation") or "any"
    if implementation not in ("any", "CoSimulation"):
        reading.problems.append(
            f"{node.where}: not for co-simulation, got implementation {implementation!r}, "
            "expected 'CoSimulation' or 'any'"
        )
        return None
    try:
        location = locate(file.package, file.base, node.text("source"))
        if location.fragment:
            raise ValueError(f"an FMU has no parts, got the fragment {location.fragment!r}")
    except ValueError as error:
        reading.problems.append(f"{node.where}: source: {error}")
        return None
    try:
        path = file.package.unpacked(location.member, reading.folder, ".fmu")
    except ConfigError as error:
        reading.problems += [f"{node.where}: {problem}" for problem in error.problems]
        return None
    try:
        if path not in reading.descriptions:
            reading.descriptions[path] = read_description(path)
    except ConfigError as error:
        hidden = [problem.replace(f"{path}: ", "") for problem in error.problems]  # a temporary folder
        reading.problems += [f"{node.where}: {problem}" for problem in hidden]
        return None
    return Component(
        name=node.text("name"),
        connectors=_connectors(reading, file, node),
        bindings=_bindings(reading, file, node, location.member),
        file=path,
        fmu=reading.descriptions[path],
        where=node.where,
    )


def _recording(reading: _Reading, file: _File, node: Node, kind: str) -> Recording | None:
    """Read a component that is a table of signals."""
    connectors = _connectors(reading, file, node)
    for connector in connectors.values():
        if connector.kind != "output":
            fault = f"a recording has outputs alone, got {connector.kind}"
            reading.problems.append(f"{connector.where}: {fault}, expected output")
        elif connector.type is not None and connector.type.kind in ("String", "Binary", "Clock"):
            fault = f"a recording has numbers alone, got {connector.type.kind}"
            reading.problems.append(f"{connector.where}: {fault}, expected Real, Integer or Boolean")
    if node.child(ssd("ParameterBindings")) is not None:
        reading.problems.append(f"{node.where}: values for a recording are not understood, expected none")
    try:
        location = locate(file.package, file.base, node.text("source"))
        if location.fragment:
            raise ValueError(f"a recording has no parts, got the fragment {location.fragment!r}")
        path = file.package.unpacked(location.member, reading.folder, ".csv" if kind == TABLES[0] else None)
        is_csv = path.suffix.lower() == ".csv"
        time = time_column(file.package.read(location.member)) if is_csv else "time"
    except (ValueError, ConfigError) as error:
        problems = error.problems if isinstance(error, ConfigError) else [f"source: {error}"]
        reading.problems += [f"{node.where}: {problem}" for problem in problems]
        return None
    member = file.package.name_of(location.member).removeprefix(f"{reading.label}: ")
    return Recording(node.text("name"), connectors, path, member, time, node.where)


def _described_elsewhere(reading: _Reading, file: _File, node: Node, kind: str) -> SubSystem | None:
    """System of another file; the component's values come after, and so over, its own."""
    text = node.text("source")
    try:
        if text.startswith("#"):
            inner, system = file, _with_id(reading, file, node, text[1:])
        else:
            found = _inner_file(reading, file, text, kind)
            inner, system = (file, None) if found is None else (found, _root_system(reading, found))
    except (ValueError, ConfigError) as error:
        problems = error.problems if isinstance(error, ConfigError) else [f"source: {error}"]
        reading.problems += [f"{node.where}: {problem}" for problem in problems]
        return None
    if system is None:
        return None
    _refuse_inner_coupling(reading, inner, file)
    own = _connectors(reading, file, node)
    for name, connector in own.items():
        if name not in system.connectors:
            known = expected(name, system.connectors)
            reading.problems.append(f"{connector.where}: no such connector of {text!r}, {known}")
        elif connector.kind != system.connectors[name].kind:
            kind_inside = system.connectors[name].kind
            reading.problems.append(
                f"{connector.where}: kind differs from that of {text!r}, got {connector.kind}, "
                f"expected {kind_inside}"
            )
    bindings = (*system.bindings, *_bindings(reading, file, node, None))
    return replace(system, name=node.text("name"), bindings=bindings, where=node.where)


def _with_id(reading: _Reading, file: _File, node: Node, name: str) -> SubSystem | None:
    systems = [one for one in file.root.element.iter(ssd("System")) if one.get("id") == name]
    if not systems:
        raise ValueError(f"no system with this id in the file, got {'#' + name!r}")
    if any(one is systems[0] for one in node.element.iterancestors()):
        raise ValueError(f"contains itself, got {'#' + name!r}, expected systems that end")
    mark = f"#{name}"
    if mark in file.enclosing:
        raise ValueError(f"contains itself, got {mark!r}, expected systems that end")
    return _system(reading, replace(file, enclosing=(*file.enclosing, mark)), Node(systems[0], node.file))


def _inner_file(reading: _Reading, file: _File, source: str, kind: str) -> _File | None:
    location = locate(file.package, file.base, source)
    if kind == DEFINITION:
        return _open(reading, file.package, location.member, file.enclosing)
    label = file.package.name_of(location.member)
    if len(file.enclosing) > MOST_NESTED:
        raise ValueError(f"nested too deeply, expected at most {MOST_NESTED} files")
    archive = Archive(file.package.read(location.member), label)
    member = location.fragment or default_structure(archive)
    return _open(reading, archive, member, file.enclosing)


def default_structure(archive: Archive) -> str:
    """
    Name the structure file that an archive means: `SystemStructure.ssd`, or the only one at its root.

    Raises:
        ConfigError: If there is none, or several.
    """
    if archive.has(STRUCTURE):
        return STRUCTURE
    structures = [name for name in archive.names if name.lower().endswith(".ssd")]
    at_root = [name for name in structures if "/" not in name]
    if len(at_root) == 1:
        return at_root[0]
    got = ", ".join(sorted(structures)) or "none"
    raise ConfigError([f"{archive.label}: no {STRUCTURE} at the root of the archive, got {got}"])


def _refuse_inner_coupling(reading: _Reading, inner: _File, outer: _File) -> None:
    """A system within another keeps no order, delays and events of its own."""
    if inner is outer:
        return
    coupling = _coupling(reading, inner.root)
    if coupling is not None:
        reading.problems.append(
            f"{coupling.where}: coupling of a system within another is not understood, "
            "expected it on the outermost system alone"
        )


def _connectors(reading: _Reading, file: _File, node: Node) -> dict[str, Connector]:
    found: dict[str, Connector] = {}
    for one in node.children(f"{ssd('Connectors')}/{ssd('Connector')}"):
        made = Connector(
            name=one.text("name"),
            kind=one.text("kind"),
            type=read_type(one, file.scope, reading.problems),
            where=one.where,
            shape=tuple(_size(dimension) for dimension in one.children(ssc("Dimension"))),
        )
        if made.name in found:
            reading.problems.append(f"{one.where}: twice on {node.text('name')!r}, expected one of a name")
        found[made.name] = made
    return found


def _size(dimension: Node) -> int | None:
    size = dimension.get("size")
    return None if size is None else integer(size)


def _link(reading: _Reading, node: Node) -> Link:
    return Link(
        start=End(node.get("startElement") or None, node.text("startConnector")),
        end=End(node.get("endElement") or None, node.text("endConnector")),
        converts_units=not boolean(node.get("suppressUnitConversion") or "false"),
        transformation=read_transformation(node, reading.problems),
        where=node.where,
    )


def _bindings(reading: _Reading, file: _File, node: Node, member: str | None) -> tuple[Binding, ...]:
    """Bindings of an element; `member` is the file of a component's FMU."""
    made = (
        _binding(reading, file, one, member)
        for one in node.children(f"{ssd('ParameterBindings')}/{ssd('ParameterBinding')}")
    )
    return tuple(binding for binding in made if binding is not None)


def _binding(reading: _Reading, file: _File, node: Node, member: str | None) -> Binding | None:
    holder = node.child(ssd("ParameterValues"))
    inline = None if holder is None else holder.child(ssv("ParameterSet"))
    root = _content(reading, file, node, inline, ssv("ParameterSet"), member)
    if root is None:
        return None
    outer = file.scope if inline is not None else Scope()
    values: tuple[Given, ...] = read_parameters(root, outer, reading.problems)
    renamings: tuple[Renaming, ...] | None = None
    mapping = node.child(ssd("ParameterMapping"))
    if mapping is not None:
        inner = mapping.child(ssm("ParameterMapping"))
        found = _content(reading, file, mapping, inner, ssm("ParameterMapping"), member)
        if found is None:
            return None
        renamings = read_renamings(found, reading.problems)
    return Binding(node.text("prefix"), values, renamings, node.where)


_CONTENTS = {
    ssv("ParameterSet"): (PARAMETER_SET, grammar.VALUES),
    ssm("ParameterMapping"): (PARAMETER_MAPPING, grammar.MAPPING),
    ssb("SignalDictionary"): (SIGNAL_DICTIONARY, grammar.DICTIONARY),
}


def _content(
    reading: _Reading, file: _File, node: Node, inline: Node | None, root: str, member: str | None
) -> Node | None:
    """Content that an element holds itself or names by its source."""
    kind, rules = _CONTENTS[root]
    given = node.get("type") or kind
    if given != kind:
        reading.problems.append(f"{node.where}: type is not understood, got {given!r}, expected {kind!r}")
        return None
    source = node.get("source")
    if (source is None) == (inline is None):
        got = "neither" if source is None else "both"
        reading.problems.append(f"{node.where}: got {got}, expected a source or its content inside")
        return None
    if source is None:
        return inline
    try:
        package, base = _base_of(file, node, member)
        location = locate(package, base, source)
        if location.fragment:
            raise ValueError(f"a fragment is not understood, got {location.fragment!r}")
    except (ValueError, ConfigError) as error:
        problems = error.problems if isinstance(error, ConfigError) else [f"source: {error}"]
        reading.problems += [f"{node.where}: {problem}" for problem in problems]
        return None
    return _xml(reading, package, location.member, root, rules)


def _base_of(file: _File, node: Node, member: str | None) -> tuple[Package, str]:
    """Where a source starts: the folder of the structure, or the component's archive itself."""
    if (node.get("sourceBase") or "SSD") == "SSD":
        return file.package, file.base
    if member is None:
        raise ValueError("sourceBase 'component' is understood for FMUs alone, expected 'SSD'")
    return Archive(file.package.read(member), file.package.name_of(member)), ""


def _dictionary(reading: _Reading, file: _File, node: Node) -> Dictionary | None:
    inline = node.child(ssb("SignalDictionary"))
    root = _content(reading, file, node, inline, ssb("SignalDictionary"), None)
    if root is None:
        return None
    own = read_scope(root, reading.problems)
    outer = file.scope if inline is not None else Scope()
    scope = Scope({**outer.units, **own.units}, {**outer.enumerations, **own.enumerations})
    entries: dict[str, DataType] = {}
    for one in root.children(ssb("DictionaryEntry")):
        made = read_type(one, scope, reading.problems)
        if made is None:
            reading.problems.append(f"{one.where}: has no type, expected one")
        _add(entries, one, made, "entry", reading)
    return Dictionary(node.text("name"), entries, node.where)
