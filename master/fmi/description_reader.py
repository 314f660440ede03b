"""
The one reader of modelDescription.xml, of FMI 2.0 and 3.0 alike.

It reports every fault with the element where it is, and reads a description of 100 000 variables in
about a second.
"""

from __future__ import annotations

import gc
import itertools
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from xml.etree import ElementTree as ET

from master.errors import ConfigError, expected
from master.text.archive import Archive, ArchiveError, NotAnArchiveError
from master.text.scalar import Plain
from master.text.xml import parsed_xml

from . import value_types
from .description import DeclaredDelay, Description, Kind, Variable
from .linearity import declared_learning, declared_linear
from .model_elements import Faults, ModelTypes
from .values import parse

DESCRIPTION = "modelDescription.xml"

_VERSION = re.compile(r"(2\.0(\.\d+)?|3\.0(\.\d+)?(-.+)?)")
_MOST_FAULTS = 30  # shown of one file
MOST_ELEMENTS = 250_000  # of all arrays together: each is a variable of its own
_LARGEST_REFERENCE = 2**32 - 1

_KINDS = {
    **dict.fromkeys(("Real", "Float64", "Float32"), Kind.REAL),
    "Boolean": Kind.BOOLEAN,
    "String": Kind.STRING,
}
_TYPES_2 = {
    "Real": value_types.FLOAT64,
    "Integer": value_types.INT32,
    "Enumeration": value_types.INT32,
    "Boolean": value_types.INT_BOOLEAN,
    "String": value_types.INT32,
}
_NOT_EXCHANGED_3 = {"Clock": "a clock", "Binary": "a binary"}
_TYPES_3 = {
    **{name: code for code, name in enumerate(value_types.NAMES)},
    **dict.fromkeys(("Enumeration", "String", *_NOT_EXCHANGED_3), value_types.INT64),
}

_FIXED = ("fixed", "tunable")
_VARIABILITIES = {
    "parameter": _FIXED,
    "structuralParameter": _FIXED,
    "calculatedParameter": _FIXED,
    "input": ("discrete", "continuous"),
    "output": ("constant", "discrete", "continuous"),
    "local": ("constant", "fixed", "tunable", "discrete", "continuous"),
    "independent": ("continuous",),
}
_INITIALS = ("exact", "approx", "calculated")


@dataclass(slots=True)
class _Declared:
    """A variable as it is written: a whole array is one, an alias of FMI 3.0 is one of its own."""

    whole: Variable
    where: str
    dimensions: Sequence[ET.Element] = ()
    starts: Sequence[str] = ()
    not_exchanged: str = ""
    is_ticked: bool = False
    parts: tuple[Variable, ...] = field(default=())


def read_description(path: Path, structure: Mapping[str, int] | None = None) -> Description:
    """
    Read the model description of an FMU 2.0 or 3.0 for co-simulation, once for each state of a file.

    Args:
        path: An FMU or a folder that one was unpacked into.
        structure: Values of structural parameters (FMI 3.0) that differ from the FMU's own.

    Raises:
        ConfigError: With every fault, if the file is not such an FMU.
    """
    return _read(path, path.absolute(), _state(path), tuple(sorted((structure or {}).items())))


def _state(path: Path) -> tuple[int, int]:
    """Time of change [ns] and size of what is read, zeros if there is nothing."""
    try:
        stat = (path / DESCRIPTION if path.is_dir() else path).stat()
    except OSError:
        return 0, 0
    return stat.st_mtime_ns, stat.st_size


@lru_cache(maxsize=256)
def _read(path: Path, _: Path, __: tuple[int, int], structure: tuple[tuple[str, int], ...]) -> Description:
    # nothing of the many objects made here is garbage: searching them for it takes a third of the time
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        return DescriptionReader(path, dict(structure)).read()
    finally:
        if was_enabled:
            gc.enable()


class DescriptionReader:
    """Reads one FMU's description."""

    def __init__(self, path: Path, structure: Mapping[str, int]) -> None:
        self.path = path
        self.structure = structure
        self.faults = Faults(path)

    def read(self) -> Description:
        """Read it; ConfigError with every fault."""
        root = self._root()
        version = root.get("fmiVersion", "")
        if root.tag != "fmiModelDescription" or not _VERSION.fullmatch(version):
            got = version or ("none" if root.tag == "fmiModelDescription" else f"<{root.tag}>")
            raise ConfigError([f"{self.path}: FMI version not supported, got {got!r}, expected 2.0 or 3.0"])
        is_2 = version.startswith("2")
        interface = self._interface(root)
        types = ModelTypes(root, is_2, self.faults)
        declared = self._declared(root, is_2, types)
        self._expand(declared)
        self._refuse_double_names(declared)
        description = Description(
            path=self.path,
            fmi_version=version,
            model_name=root.get("modelName", ""),
            model_identifier=interface.get("modelIdentifier", ""),
            token=root.get("guid" if is_2 else "instantiationToken", ""),
            variables=_with_aliases([v for d in declared for v in d.parts]),
            tool=root.get("generationTool", ""),
            delays=tuple(self._delays(root)),
            can_get_and_set_state=self._flag(
                interface, "canGetAndSetFMUstate" if is_2 else "canGetAndSetFMUState"
            ),
            can_serialise_state=self._flag(
                interface, "canSerializeFMUstate" if is_2 else "canSerializeFMUState"
            ),
            needs_execution_tool=self._flag(interface, "needsExecutionTool"),
            once_per_process=self._flag(interface, "canBeInstantiatedOnlyOncePerProcess"),
            has_event_mode=self._flag(interface, "hasEventMode"),
            not_exchanged={d.whole.name: d.not_exchanged for d in declared if d.not_exchanged},
            ticked_clocks=tuple(d.whole.name for d in declared if d.is_ticked),
            short_starts=frozenset(
                d.whole.name for d in declared if d.dimensions and len(d.starts) != len(d.parts)
            ),
            feedthrough=self._feedthrough(root, is_2, declared),
            influences=_influences(root),
            linear=declared_linear(root),
            learning=declared_learning(root),
        )
        self._check_linearity(description)
        self.faults.raise_if_any(_MOST_FAULTS)
        return description

    def _root(self) -> ET.Element:
        try:
            with Archive(self.path) as archive:
                return parsed_xml(archive.read(DESCRIPTION))
        except FileNotFoundError:
            fault = "no such file, expected an FMU"
        except NotAnArchiveError:
            fault = f"not an FMU, expected a zip archive with {DESCRIPTION}"
        except ArchiveError as error:
            fault = f"cannot be read: {error}"
        except OSError as error:
            fault = f"cannot be read, got {error.strerror}, expected an FMU"
        except KeyError:
            fault = f"not an FMU, expected {DESCRIPTION} in the archive"
        except (ET.ParseError, LookupError, ValueError) as error:  # the latter two: of its encoding
            fault = f"{DESCRIPTION} is not XML: {error}"
        raise ConfigError([f"{self.path}: {fault}"])

    def _interface(self, root: ET.Element) -> ET.Element:
        interface = root.find("CoSimulation")
        if interface is None:
            others = {"ModelExchange": "model exchange", "ScheduledExecution": "scheduled execution"}
            got = " and ".join(words for tag, words in others.items() if root.find(tag) is not None)
            what = f"an FMU for {got} only" if got else "no CoSimulation element"
            raise ConfigError([f"{self.path}: not for co-simulation, got {what}"])
        identifier = interface.get("modelIdentifier", "")
        if not re.fullmatch(r"[^/\\:\0]+", identifier) or identifier.startswith("."):
            self.faults.add(
                "CoSimulation", f"modelIdentifier: got {identifier or 'none'!r}, expected a file name"
            )
        token = "guid" if root.get("fmiVersion", "").startswith("2") else "instantiationToken"
        if not root.get(token):
            self.faults.add("fmiModelDescription", f"{token}: missing, expected a text")
        return interface

    def _flag(self, e: ET.Element, key: str) -> bool:
        return bool(self.faults.truth(e, key, e.tag))

    def _declared(self, root: ET.Element, is_2: bool, types: ModelTypes) -> list[_Declared]:
        if root.find("ModelVariables/*") is None:
            self.faults.add("ModelVariables", "got none, expected at least one variable")
        read = self._scalar_variable if is_2 else self._variable_3
        found: list[_Declared] = []
        for i, e in enumerate(root.iterfind("ModelVariables/*"), 1):
            found += read(e, f"ModelVariables/{e.tag} {e.get('name') or f'number {i}'!r}", types)
        return found

    def _scalar_variable(self, e: ET.Element, where: str, types: ModelTypes) -> list[_Declared]:
        typed = e[0] if len(e) and e[0].tag in _TYPES_2 else next((p for p in e if p.tag in _TYPES_2), None)
        if e.tag != "ScalarVariable" or typed is None:
            what = "unknown element" if e.tag != "ScalarVariable" else "no type"
            self.faults.add(where, f"{what}, expected a ScalarVariable with one of {', '.join(_TYPES_2)}")
            return [self._nothing(e, where)]
        start = typed.get("start")
        starts = [] if start is None else [start]
        code = _TYPES_2[typed.tag]
        return [self._variable(e, typed, where, code, starts, "continuous", types)]

    def _variable_3(self, e: ET.Element, where: str, types: ModelTypes) -> list[_Declared]:
        if e.tag not in _TYPES_3:
            self.faults.add(where, f"unknown element, expected one of {', '.join(_TYPES_3)}")
            return [self._nothing(e, where)]
        if e.tag in ("String", "Binary"):
            starts = [part.get("value", "") for part in e.iterfind("Start")]
        else:
            starts = e.get("start", "").split()
            if e.get("start") is not None and not starts:
                self.faults.add(where, f"start: got {e.get('start')!r}, expected a value")
        causality = e.get("causality", "local")
        is_real = e.tag in ("Float64", "Float32")
        usual = "fixed" if "arameter" in causality else "continuous" if is_real else "discrete"
        declared = self._variable(e, e, where, _TYPES_3[e.tag], starts, usual, types)
        declared.dimensions = e.findall("Dimension")
        if declared.dimensions and e.tag == "String":
            declared.not_exchanged = declared.not_exchanged or "an array of strings"
        elif not declared.dimensions and len(starts) > 1:
            self.faults.add(where, f"start: got {len(starts)} values, expected one")
        declared.not_exchanged = declared.not_exchanged or _NOT_EXCHANGED_3.get(e.tag, "")
        declared.is_ticked = (
            e.tag == "Clock" and causality == "input" and e.get("intervalVariability") != "triggered"
        )
        return [declared, *self._aliases(e, where, declared)]

    def _aliases(self, e: ET.Element, where: str, declared: _Declared) -> Iterator[_Declared]:
        """Read a variable's aliases (FMI 3.0), which have a name, description and display unit."""
        for alias in e.iterfind("Alias"):
            name = alias.get("name")
            if not name:
                self.faults.add(where, "Alias: name: missing, expected a text")
                continue
            whole = replace(
                declared.whole,
                name=name,
                description=alias.get("description", declared.whole.description),
                display_unit=alias.get("displayUnit", declared.whole.display_unit),
            )
            yield replace(declared, whole=whole, where=f"{where}/Alias {name!r}", is_ticked=False)

    def _variable(
        self,
        e: ET.Element,
        typed: ET.Element,
        where: str,
        code: int,
        starts: list[str],
        usual: str,
        types: ModelTypes,
    ) -> _Declared:
        """Read what the variables of both versions have; `typed` is the element with the attributes."""
        kind = _KINDS.get(typed.tag, Kind.INTEGER)
        name = e.get("name")
        if not name:
            self.faults.add(where, "name: missing, expected a text")
        reference = self.faults.integer(e, "valueReference", where, 0, _LARGEST_REFERENCE, required=True)
        causality = self.faults.choice(e, "causality", where, _VARIABILITIES) or "local"
        variability = self.faults.choice(e, "variability", where, _VARIABILITIES["local"]) or usual
        if variability not in _VARIABILITIES[causality]:
            allowed = " or ".join(_VARIABILITIES[causality])
            self.faults.add(
                where,
                f"variability: got {variability!r} with causality {causality}, expected {allowed}",
            )
        initial = self.faults.choice(e, "initial", where, _INITIALS)
        if kind is not Kind.STRING and typed.tag not in _NOT_EXCHANGED_3:
            self._check_starts(starts, kind, where)
        attributes = types.attributes(typed, where)
        of_integers = kind is Kind.INTEGER
        whole = Variable(
            name=name or "",
            reference=reference or 0,
            kind=kind,
            value_type=code,
            causality=causality,
            variability=variability,
            initial=initial or _usual_initial(causality, variability),
            start=starts[0] if starts else None,
            unit=types.unit(attributes),
            minimum=self.faults.number(attributes, "min", where, of_integers=of_integers),
            maximum=self.faults.number(attributes, "max", where, of_integers=of_integers),
            nominal=self.faults.number(attributes, "nominal", where),
            items=types.items(typed),
            description=e.get("description", ""),
            display_unit=attributes.get("displayUnit"),
            quantity=attributes.get("quantity"),
        )
        time = "the time" if causality == "independent" else ""
        return _Declared(whole, where, starts=starts, not_exchanged=time)

    def _check_starts(self, starts: list[str], kind: Kind, where: str) -> None:
        for i, word in enumerate(starts):
            text = word.strip()
            starts[i] = text
            if kind is Kind.BOOLEAN:
                fits = text in ("true", "false", "1", "0")
            else:
                fits = self.faults.is_integer(text) if kind is Kind.INTEGER else self.faults.is_number(text)
            if not fits:
                self.faults.add(where, f"start: got {word!r}, expected a value of type {kind.value}")
                starts[i] = "0"

    @staticmethod
    def _nothing(e: ET.Element, where: str) -> _Declared:
        """Take the place of a variable that cannot be read, so that indexes count on."""
        whole = Variable(e.get("name", ""), 0, Kind.REAL, value_types.FLOAT64, "local", "continuous")
        return _Declared(whole, where, not_exchanged="unreadable")

    def _expand(self, declared: Iterable[_Declared]) -> None:
        """Split arrays into their elements; start values for another size are left out."""
        declared = list(declared)
        sizes = {d.whole.reference: d for d in declared if d.whole.causality == "structuralParameter"}
        for d in sizes.values():
            if d.whole.name in self.structure:
                d.starts = [str(self.structure[d.whole.name])]
        n_elements = 0
        for d in declared:
            if d.not_exchanged:
                continue
            lengths = [self._length(e, d.where, sizes) for e in d.dimensions]
            shape = [n for n in lengths if n is not None]
            n = math.prod(shape)
            if len(shape) < len(lengths):
                continue
            n_elements += n if shape else 0
            if n_elements > MOST_ELEMENTS:
                before = f", {n_elements} with those of the arrays before" * (n_elements > n)
                got = f"got {n} elements{before}"
                self.faults.add(d.where, f"Dimension: {got}, expected at most {MOST_ELEMENTS}")
                n_elements -= n
            elif not shape:
                d.parts = (d.whole,)
            elif self._is_resized(d, sizes) and len(d.starts) not in (1, n):
                d.starts = ()
                d.parts = tuple(_elements(d, shape))
            elif len(d.starts) > n:
                self.faults.add(d.where, f"start: got {len(d.starts)} values, expected {n}")
            else:
                d.parts = tuple(_elements(d, shape))

    def _is_resized(self, d: _Declared, sizes: Mapping[int, _Declared]) -> bool:
        """Whether the size of an array depends on a structural parameter with another value."""
        references = (e.get("valueReference", "") for e in d.dimensions)
        parameters = (sizes.get(int(text)) for text in references if text.isdecimal())
        return any(p is not None and p.whole.name in self.structure for p in parameters)

    def _length(self, e: ET.Element, of: str, sizes: Mapping[int, _Declared]) -> int | None:
        """Length along a dimension: fixed, or the start value of a structural parameter; None: a fault."""
        where = f"{of}/Dimension"
        if e.get("valueReference") is None:
            return self.faults.integer(e, "start", where, 0, 2**64 - 1, required=True)
        reference = self.faults.integer(e, "valueReference", where, 0, _LARGEST_REFERENCE, required=True)
        parameter = None if reference is None else sizes.get(reference)
        if parameter is None or not parameter.starts or parameter.whole.kind is not Kind.INTEGER:
            self.faults.add(
                where, f"valueReference: got {reference}, expected a structural parameter with a start value"
            )
            return None
        return max(0, int(parameter.starts[0]))

    def _refuse_double_names(self, declared: Iterable[_Declared]) -> None:
        seen: set[str] = set()
        for d in declared:
            # an array's name names all of its elements
            names = {d.whole.name, *(v.name for v in d.parts)} if d.dimensions else {d.whole.name}
            for name in sorted(names & seen):
                self.faults.add(d.where, f"name: {name!r} is there twice, expected it once")
            seen |= names

    def _feedthrough(
        self, root: ET.Element, is_2: bool, declared: Sequence[_Declared]
    ) -> dict[str, tuple[str, ...]]:
        """Inputs on which each output depends at once; all inputs where the FMU does not say."""
        inputs = [d for d in declared if d.whole.causality == "input" and d.parts]
        every = tuple(v.name for d in inputs for v in d.parts)
        names_of: dict[tuple[int, int], list[str]] = {}
        for d in inputs:
            names_of.setdefault(_key(d.whole), []).extend(v.name for v in d.parts)
        stated: dict[tuple[int, int], tuple[str, ...]] = {}
        for output, dependencies in self._unknowns(root, is_2, declared):
            if dependencies is not None:
                keys = dict.fromkeys(_key(d.whole) for d in dependencies)
                stated[_key(output.whole)] = tuple(n for key in keys for n in names_of.get(key, ()))
        return {
            v.name: stated.get(_key(d.whole), every)
            for d in declared
            if d.whole.causality == "output"
            for v in d.parts
        }

    def _unknowns(
        self, root: ET.Element, is_2: bool, declared: Sequence[_Declared]
    ) -> Iterator[tuple[_Declared, list[_Declared] | None]]:
        """Outputs of the model structure with what they depend on; None: the FMU does not say."""
        if is_2:
            key, what = "index", f"from 1 to {len(declared)}, the number of variables"
            known = dict(enumerate(declared, 1))
            tags: tuple[str, ...] = ("Outputs/Unknown", "Derivatives/Unknown", "InitialUnknowns/Unknown")
        else:
            key, what = "valueReference", "the reference of a variable"
            known = {d.whole.reference: d for d in reversed(declared)}
            tags = ("Output", "ContinuousStateDerivative", "ClockedState", "InitialUnknown", "EventIndicator")
        for tag in tags:
            for i, e in enumerate(root.iterfind(f"ModelStructure/{tag}"), 1):
                where = f"ModelStructure/{tag} number {i}"
                number = self.faults.integer(e, key, where, 0, _LARGEST_REFERENCE, required=True)
                unknown = None if number is None else known.get(number)
                if number is not None and unknown is None:
                    self.faults.add(where, f"{key}: got {number}, expected {what}")
                listed = e.get("dependencies")
                dependencies: list[_Declared] | None = None if listed is None else []
                for word in (listed or "").split():
                    of = known.get(int(word)) if word.isdecimal() else None
                    if of is None:
                        self.faults.add(where, f"dependencies: got {word!r}, expected {what}")
                    elif dependencies is not None:
                        dependencies.append(of)
                if tag == tags[0] and unknown is not None:
                    yield unknown, dependencies

    def _check_linearity(self, description: Description) -> None:
        """Refuse what an FMU declares of its linearity and learning but does not have."""
        for linear in description.linear:
            where = f"Coupling/Linear of {linear.parameter!r}"
            self._check_declared(description, where, linear.parameter, linear.value)
            if linear.frequency is not None:
                self._check_declared(description, f"{where}: frequency", linear.frequency)
        for learning in description.learning:
            where = f"Coupling/Learning by {learning.by!r}"
            self._check_declared(description, where, learning.by, learning.item)
            self._check_declared(description, f"{where}: held", learning.held_by, "true")

    def _check_declared(
        self, description: Description, where: str, name: str, value: str | None = None
    ) -> None:
        variable = description.by_name.get(name)
        if variable is None or variable.kind is Kind.STRING:
            self.faults.add(where, f"no such variable, got {name!r}, {expected(name, description.by_name)}")
        elif value is not None:
            try:
                parse(variable, Plain(value))
            except ValueError as error:
                self.faults.add(where, f"value not allowed for {name}, got {value!r}, {error}")

    def _delays(self, root: ET.Element) -> Iterator[DeclaredDelay]:
        for e in root.iterfind(".//Coupling/Delay"):
            where = f"Coupling/Delay of {e.get('input', '')!r}"
            yield DeclaredDelay(
                input=e.get("input", ""),
                kind=e.get("kind", ""),
                seconds=e.get("seconds", "0"),
                steps=self.faults.number(e.attrib, "steps", where),
                by=e.get("by"),
                cases={
                    w.get("item", ""): self.faults.number(w.attrib, "steps", where) or 0.0
                    for w in e.iter("When")
                },
                reason=e.get("reason", ""),
            )


def _key(v: Variable) -> tuple[int, int]:
    """What variables that share a value have in common: the function that gets it and the reference."""
    return (-1 if v.kind is Kind.STRING else v.value_type, v.reference)


def _usual_initial(causality: str, variability: str) -> str | None:
    """How a variable that does not say it gets its initial value."""
    if variability == "constant" or causality in ("parameter", "structuralParameter"):
        return "exact"
    return None if causality in ("input", "independent") else "calculated"


def _elements(d: _Declared, shape: Sequence[int]) -> Iterator[Variable]:
    """Elements in row-major order; one start value is that of all, a short list leaves the rest open."""
    places = itertools.product(*(range(1, n + 1) for n in shape))
    n = math.prod(shape)
    starts: Sequence[str | None] = d.starts if len(d.starts) != 1 else [d.starts[0]] * n
    for i, place in enumerate(places):
        yield replace(
            d.whole,
            name=f"{d.whole.name}[{','.join(map(str, place))}]",
            start=starts[i] if i < len(starts) else None,
            size=n,
            element=i,
            array=d.whole.name,
        )


def _with_aliases(variables: Sequence[Variable]) -> tuple[Variable, ...]:
    """Name the primary one in all variables that share its value, and let all have its start value."""
    sets: dict[tuple[int, int, int | None], list[Variable]] = {}
    for v in variables:
        sets.setdefault((*_key(v), v.element), []).append(v)
    if len(sets) == len(variables):
        return tuple(variables)
    found = []
    for v in variables:
        same = sets[(*_key(v), v.element)]
        primary = next((s for s in same if s.is_settable), same[0])
        if len(same) > 1:
            start = next((s.start for s in (v, primary, *same) if s.start is not None), None)
            v = replace(v, start=start, alias_of=None if v is primary else primary.name)
        found.append(v)
    return tuple(found)


def _influences(root: ET.Element) -> dict[str, tuple[str, ...]]:
    """Inputs that reach an output sooner or later, as our FMUs say it."""
    stated = root.iterfind(".//Coupling/Influence")
    return {e.get("output", ""): tuple((e.get("inputs") or "").split()) for e in stated}
