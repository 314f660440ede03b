"""Structure of a system: instances, ports, units and wires, checked as a whole. No FMU is loaded."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from master.errors import ConfigError, Problem, nearest
from master.fmi.description import Description, Kind, Variable
from master.fmi.structure import with_structure
from master.fmi.units import Conversion, conversion
from master.fmi.values import settable
from master.isolation.options import Isolation
from master.text.scalar import Setting
from master.text.signal_name import SignalName

from .config import Connection, LoadedConfig
from .connectors import described_connectors

Descriptions = Mapping[str, Description | None]
"""By instance name; None where the FMU could not be read, so that nothing is said of its variables."""


@dataclass(frozen=True)
class Instance:
    """
    One FMU of the system with the values it starts from, by the names of primary variables.

    `isolation` says how it is kept in a process of its own, None if it shares that of the run.
    """

    name: str
    description: Description
    every: int
    start: Mapping[str, float | str]
    isolation: Isolation | None = None

    def value_of(self, name: str) -> float | str | None:
        """Value of a parameter or start value: the configured one or the FMU's own."""
        if name not in self.description.by_name:
            return None
        variable = self.description.primary(name)
        return self.start.get(variable.name, variable.start_value)


@dataclass(frozen=True)
class Port:
    """A variable of an instance."""

    instance: str
    variable: Variable

    @property
    def name(self) -> str:
        """Qualified name."""
        return f"{self.instance}.{self.variable.name}"


@dataclass(frozen=True)
class Wire:
    """
    A connection between two ports that fit; the target is a primary variable.

    `delay` is in steps beyond what the order gives, `extrapolation` an order (0: hold), `tolerance`
    relative to the target's nominal value where the wire is iterated (None: that of the group).
    """

    source: Port
    target: Port
    delay: int
    conversion: Conversion
    extrapolation: int = 0
    tolerance: float | None = None


@dataclass(frozen=True)
class System:
    """
    Instances by name in the order of the file, and the wires between them.

    `unread` names the FMUs of a wrong file that could not be read; it is empty in a system that runs.

    `connectors` describes inputs and outputs of the whole by the name of the system. `inlets` are wires from
    its inputs and parameters to FMUs, `outlets` those to its outputs; `given` are values of the first, `held`
    those of outputs that come from an input of the system itself.
    """

    instances: Mapping[str, Instance]
    wires: tuple[Wire, ...]
    unread: tuple[str, ...] = ()
    connectors: Mapping[str, Description] = field(default_factory=dict)
    inlets: tuple[Wire, ...] = ()
    outlets: tuple[Wire, ...] = ()
    given: Mapping[str, float | str] = field(default_factory=dict)
    held: Mapping[str, float] = field(default_factory=dict)

    @property
    def descriptions(self) -> dict[str, Description | None]:
        """Description of each FMU, and of the system's own connectors, by instance name."""
        known = {name: i.description for name, i in self.instances.items()}
        return {**known, **dict.fromkeys(self.unread), **self.connectors}

    @cached_property
    def _into(self) -> dict[str, list[Wire]]:
        ending: dict[str, list[Wire]] = {name: [] for name in self.instances}
        for wire in self.wires:
            ending[wire.target.instance].append(wire)
        return ending

    def wires_into(self, instance: str) -> list[Wire]:
        """Wires that end at an instance."""
        return self._into[instance]

    def driven_by(self, signal: str) -> list[Wire]:
        """Wires from an input or a parameter of the whole system."""
        return [w for w in (*self.inlets, *self.outlets) if w.source.name == signal]

    def read_from(self, instance: str) -> tuple[Variable, ...]:
        """Variables of an FMU that a run reads: its outputs, and what else is an output of the system."""
        outputs = self.instances[instance].description.outputs
        known = {v.name for v in outputs}
        more = {
            w.source.variable.name: w.source.variable for w in self.outlets if w.source.instance == instance
        }
        return (*outputs, *(v for name, v in more.items() if name not in known))

    def port(self, signal: str) -> Port:
        """Find `instance.variable`; KeyError if there is none."""
        name = SignalName(signal)
        return Port(name.instance, self._described(name.instance).by_name[name.variable])

    def primary(self, signal: str) -> Port:
        """Find the primary variable of those that share a value with `instance.variable`, as `port` does."""
        name = SignalName(signal)
        return Port(name.instance, self._described(name.instance).primary(name.variable))

    def _described(self, instance: str) -> Description:
        """Describe an FMU or a connector's owner; KeyError if there is none."""
        known = self.instances.get(instance)
        return self.connectors[instance] if known is None else known.description


def build_system(
    loaded: LoadedConfig, descriptions: Descriptions, overrides: Mapping[str, tuple[str, Setting]]
) -> System:
    """
    Join a configuration and the descriptions of its FMUs.

    Args:
        loaded: The configuration.
        descriptions: By instance name.
        overrides: `instance.variable` to (where, value), from a variant and `--set`.

    Raises:
        ConfigError: With every fault: unknown variables, values that do not fit, units, double sources.
    """
    system, problems = join(loaded, descriptions, overrides)
    if problems:
        raise ConfigError(problems)
    return system


def join(
    loaded: LoadedConfig, descriptions: Descriptions, overrides: Mapping[str, tuple[str, Setting]]
) -> tuple[System, list[str]]:
    """Join as `build_system` does, and return what is right with the faults of the rest."""
    problems: list[str] = []
    descriptions = _with_structures(loaded, descriptions, overrides, problems)
    connectors = described_connectors(loaded, descriptions, problems)
    described = {**descriptions, **connectors}
    wires = _wires(loaded, described, connectors, problems)
    inner = [w for w in wires if not {w.source.instance, w.target.instance} & set(connectors)]
    joined = _Joined(
        instances={
            name: Instance(name, d, loaded.config.fmus[name].every, {}, loaded.config.fmus[name].isolation())
            for name, d in descriptions.items()
            if d is not None
        },
        connectors=connectors,
        inlets=[w for w in wires if w.source.instance in connectors and w.target.instance not in connectors],
        outlets=[w for w in wires if w.target.instance in connectors],
        connected={w.target.name for w in inner},
        unread=tuple(name for name, d in descriptions.items() if d is None),
    )
    for name, entry in loaded.config.connectors.items():
        fault = None if entry.start is None else joined.set(name, entry.start)
        problems += [] if fault is None else [f"{loaded.where('connectors', name, 'start')}: {fault}"]
    for name, instance in list(joined.instances.items()):
        own = _start(loaded, name, instance.description, joined.connected, problems)
        joined.instances[name] = replace(instance, start={**instance.start, **own})
    for signal, (where, value) in overrides.items():
        fault = joined.set(signal, value)
        problems += [] if fault is None else [f"{where}: {fault}"]
    problems += _variant_faults(loaded, joined)
    _check_signals(loaded, described, joined.outlets, problems)
    return joined.system(inner), problems


@dataclass
class _Joined:
    """What of a system values are set in."""

    instances: dict[str, Instance]
    connectors: Mapping[str, Description]
    inlets: list[Wire]
    outlets: list[Wire]
    connected: set[str]
    unread: tuple[str, ...]
    given: dict[str, float | str] = field(default_factory=dict)
    held: dict[str, float] = field(default_factory=dict)

    def system(self, wires: Sequence[Wire]) -> System:
        """Make the system; outputs that come from an input without a value have 0."""
        handed = [w for w in self.outlets if w.source.instance in self.connectors]
        return System(
            instances=self.instances,
            wires=tuple(wires),
            unread=self.unread,
            connectors=self.connectors,
            inlets=tuple(self.inlets),
            outlets=tuple(self.outlets),
            given=self.given,
            held={w.target.name: w.conversion.of(0.0) for w in handed} | self.held,
        )

    def copy(self) -> _Joined:
        """Make one whose values may change without changing these."""
        return replace(self, instances=dict(self.instances), given=dict(self.given), held=dict(self.held))

    def restructure(self, name: str, values: Mapping[str, Setting]) -> None:
        """Resize the arrays of an FMU as values say; ConfigError if that is impossible."""
        instance = self.instances.get(name)
        if instance is not None:
            structured = with_structure(instance.description, values)
            self.instances[name] = replace(instance, description=structured)

    def set(self, signal: str, value: Setting) -> str | None:
        """Set one value over those of the file; return what is wrong with it."""
        name, key = SignalName(signal).parts
        if name in self.unread:
            return None
        if name in self.connectors:
            return self._hand_in(name, key, value)
        if name not in self.instances:
            return Problem("no such FMU", got=repr(name), expected=nearest(name, self.instances))
        instance = self.instances[name]
        try:
            parsed = settable(instance.description, name, key, value, self.connected)
        except ValueError as error:
            return str(error)
        self.instances[name] = replace(instance, start={**instance.start, **parsed})
        return None

    def _hand_in(self, name: str, key: str, value: Setting) -> str | None:
        """Set an input or a parameter of the system: all that it leads to."""
        try:
            parsed = settable(self.connectors[name], name, key, value, set())
        except ValueError as error:
            return str(error)
        for variable, number in parsed.items():
            signal = f"{name}.{variable}"
            self.given[signal] = number
            for wire in (w for w in (*self.inlets, *self.outlets) if w.source.name == signal):
                carried = handed(wire, number)
                if wire.target.instance in self.connectors:
                    self.held[wire.target.name] = float(carried)
                    continue
                fault = self.set(wire.target.name, carried)
                if fault is not None:
                    return f"{wire.target.name}: {fault}"
        return None


def with_values(system: System, values: Mapping[str, Setting]) -> System:
    """
    Set values over those of a system, as an override does; they must not change its structure.

    Raises:
        ConfigError: With every value that there is no variable for, or that it does not take.
    """
    joined = _Joined(
        instances=dict(system.instances),
        connectors=system.connectors,
        inlets=list(system.inlets),
        outlets=list(system.outlets),
        connected={w.target.name for w in system.wires},
        unread=system.unread,
        given=dict(system.given),
        held=dict(system.held),
    )
    faults = {signal: joined.set(signal, value) for signal, value in values.items()}
    problems = [Problem.of_line(fault).at(signal) for signal, fault in faults.items() if fault is not None]
    if problems:
        raise ConfigError(problems)
    return joined.system(system.wires)


def handed(wire: Wire, value: float | str) -> float | str:
    """Convert a value of the system's input for what a wire leads it to; a text and a plain integer stay."""
    is_kept = isinstance(value, str) or wire.conversion.is_identity
    return value if is_kept else wire.conversion.of(float(value))


def _with_structures(
    loaded: LoadedConfig,
    descriptions: Descriptions,
    overrides: Mapping[str, tuple[str, Setting]],
    problems: list[str],
) -> Descriptions:
    """Resize arrays as the values of structural parameters say."""
    found = dict(descriptions)
    changed = {SignalName(signal): value for signal, (_, value) in overrides.items()}
    for name, d in descriptions.items():
        if d is None or not any(v.is_structural for v in d.variables):
            continue
        entry = loaded.config.fmus[name]
        own = {signal.variable: value for signal, value in changed.items() if signal.instance == name}
        try:
            found[name] = with_structure(d, {**entry.start, **entry.parameters, **own})
        except ConfigError as error:
            problems += [problem.at(loaded.where("fmus", name)) for problem in error.problems]
    return found


def _start(
    loaded: LoadedConfig, name: str, d: Description, connected: set[str], problems: list[str]
) -> dict[str, float | str]:
    entry = loaded.config.fmus[name]
    sections = {"parameters": entry.parameters, "start": entry.start}
    given = [(section, key, value) for section, part in sections.items() for key, value in part.items()]
    values: dict[str, float | str] = {}
    named: dict[str, str] = {}
    for section, key, value in sorted(given, key=lambda one: one[1] not in d.arrays):  # elements after wholes
        where = loaded.where("fmus", name, section, key)
        try:
            found = settable(d, name, key, value, connected)
        except ValueError as error:
            problems.append(f"{where}: {error}")
            continue
        other = next((named[k] for k in found if named.get(k, key) != key and named[k] not in d.arrays), None)
        if other is not None:
            problems.append(
                f"{where}: has two values, got {key!r} and {other!r}, expected one of these aliases"
            )
        values |= found
        named |= dict.fromkeys(found, key)
    return values


def _variant_faults(loaded: LoadedConfig, joined: _Joined) -> list[str]:
    """Faults of all variants, chosen or not; a variant may give arrays other sizes."""
    faults: list[str] = []
    for variant, fmus in loaded.config.variants.items():
        for name, values in fmus.items():
            own = joined.copy()
            try:
                own.restructure(name, values)
            except ConfigError as error:
                faults += [p.at(loaded.where("variants", variant, name)) for p in error.problems]
                continue
            for key, value in values.items():
                fault = own.set(f"{name}.{key}", value)
                if fault is not None:
                    faults.append(f"{loaded.where('variants', variant, name, key)}: {fault}")
    return faults


def _wires(
    loaded: LoadedConfig, descriptions: Descriptions, connectors: Collection[str], problems: list[str]
) -> list[Wire]:
    wires: list[Wire] = []
    first: dict[str, tuple[int, str]] = {}
    for i, connection in _scalars(loaded, descriptions, problems):
        ends = {"from": connection.source, "to": connection.target}
        at_system = {SignalName(signal).instance for signal in ends.values()} & set(connectors)
        source, target = (
            _port(loaded, descriptions, (i, end), signal, _allowed(end, signal, at_system), problems)
            for end, signal in ends.items()
        )
        reached = connection.target if target is None else target.name
        if reached in first:
            j, name = first[reached]
            where = loaded.where("connections", i, "to")
            alias = "" if name == connection.target else f", an alias of {name!r}"
            other = loaded.document.name_of(("connections", j))
            problems.append(
                f"{where}: has two sources, got {connection.target!r} again{alias}, "
                f"expected one connection (the other is {other})"
            )
            continue
        first[reached] = (i, connection.target)
        if source is not None and target is not None:
            wires += _wire(loaded, i, connection, source, target, problems)
            if at_system and (connection.delay or connection.extrapolation or connection.tolerance):
                fault = "a connector of the system has the value at once, got a delay or another rule"
                problems.append(f"{loaded.where('connections', i)}: {fault}, expected none")
    return wires


def _scalars(
    loaded: LoadedConfig, descriptions: Descriptions, problems: list[str]
) -> Iterator[tuple[int, Connection]]:
    """Connections with their places; one of whole arrays becomes one of each pair of elements."""
    for i, connection in enumerate(loaded.config.connections):
        source, target = (_elements(descriptions, s) for s in (connection.source, connection.target))
        if not source or not target:
            yield i, connection
        elif [_place(s) for s in source] != [_place(s) for s in target]:
            problems.append(
                f"{loaded.where('connections', i)}: shapes differ, got {connection.source} up to "
                f"{_place(source[-1])} -> {connection.target} up to {_place(target[-1])}, expected the same"
            )
        else:
            for s, t in zip(source, target, strict=True):
                yield i, connection.model_copy(update={"source": s, "target": t})


def _elements(descriptions: Descriptions, signal: str) -> list[str]:
    """Signals of the elements of a whole array; empty for anything else."""
    name = SignalName(signal)
    description = descriptions.get(name.instance)
    if description is None:
        return []
    return [f"{name.instance}.{v.name}" for v in description.arrays.get(name.variable, ())]


def _place(element: str) -> str:
    return "[" + element.rpartition("[")[2]


def _wire(
    loaded: LoadedConfig, i: int, c: Connection, source: Port, target: Port, problems: list[str]
) -> list[Wire]:
    ignored = c.units == "ignored"
    found = Conversion() if ignored else conversion(source.variable.unit, target.variable.unit)
    if found is None:
        problems.append(
            f"{loaded.where('connections', i)}: units differ, "
            f"got {_with_unit(source)} -> {_with_unit(target)}, expected the same quantity"
        )
        return []
    kinds = {source.variable.kind, target.variable.kind}
    is_handed_in = source.variable.causality != "output" and target.variable.causality != "output"
    if Kind.STRING in kinds and not (is_handed_in and len(kinds) == 1):
        problems.append(f"{loaded.where('connections', i)}: strings cannot be connected, got {source.name}")
        return []
    if c.map and Kind.REAL in (source.variable.kind, target.variable.kind):
        problems.append(
            f"{loaded.where('connections', i)}: a map is for integers, Booleans and enumerations, "
            f"got {source.name} ({source.variable.kind.value}) -> "
            f"{target.name} ({target.variable.kind.value})"
        )
        return []
    table = Conversion(table=tuple(sorted((float(key), float(value)) for key, value in c.map.items())))
    carried = found.then(table).then(Conversion(c.factor, c.offset))
    return [Wire(source, target, c.delay, carried, c.extrapolation, c.tolerance)]


def _with_unit(port: Port) -> str:
    return f"{port.name} [{port.variable.unit_name}]"


def _allowed(end: str, signal: str, at_system: Collection[str]) -> tuple[str, ...]:
    """Causalities of one end of a connection; `at_system` has the system's name if it is at either end."""
    if not at_system:
        return ("output",) if end == "from" else ("input",)
    if SignalName(signal).instance in at_system:
        return ("input", "parameter") if end == "from" else ("output",)
    return ("output", "calculatedParameter", "local") if end == "from" else ("input", "parameter")


def _port(
    loaded: LoadedConfig,
    descriptions: Descriptions,
    place: tuple[int, str],
    signal: str,
    causalities: tuple[str, ...],
    problems: list[str],
) -> Port | None:
    fault = signal_fault(descriptions, signal, causalities)
    if fault is not None:
        problems.append(f"{loaded.where('connections', *place)}: {fault}")
        return None
    name = SignalName(signal)
    description = descriptions[name.instance]
    if description is None:
        return None
    is_source = place[1] == "from"
    variable = description.by_name[name.variable] if is_source else description.primary(name.variable)
    return Port(name.instance, variable)


def signal_fault(
    descriptions: Descriptions, signal: str, causalities: tuple[str, ...] | None
) -> Problem | None:
    """
    Say what is wrong with `instance.variable`.

    None if it exists with one of the causalities, or if its FMU could not be read.
    """
    try:
        instance, variable = SignalName(signal).parts
    except ValueError:
        return Problem("not a signal", got=repr(signal), expected="'instance.variable'")
    if instance not in descriptions:
        return Problem("no such FMU", got=repr(instance), expected=nearest(instance, descriptions))
    d = descriptions[instance]
    if d is None:
        return None
    known = d.by_name.get(variable)
    if known is not None and (causalities is None or known.causality in causalities):
        return None
    names = [v.name for v in d.variables if causalities is None or v.causality in causalities]
    if variable in d.not_exchanged:
        got = f"{signal} ({d.not_exchanged[variable]})"
        return Problem("cannot be exchanged", got=got, expected=nearest(variable, names))
    what = "variable" if causalities is None else " or ".join(causalities)
    return Problem(
        f"no such {what} of {instance} ({d.model_name})",
        got=repr(variable),
        expected=nearest(variable, names),
    )


def _check_signals(
    loaded: LoadedConfig, descriptions: Descriptions, outlets: Sequence[Wire], problems: list[str]
) -> None:
    compare = loaded.config.compare
    sources = {w.target.name: w.source for w in outlets}
    named = {} if compare is None else {k: v for k, v in compare.model_dump().items() if isinstance(v, str)}
    for key, signal in named.items():
        fault = signal_fault(descriptions, signal, ("output",))
        if fault is not None:
            problems.append(f"{loaded.where('compare', key)}: {fault}")
        elif signal in sources and sources[signal].variable.causality != "output":
            got = f"{signal}, which is {sources[signal].name}"
            problems.append(f"{loaded.where('compare', key)}: no output of an FMU, got {got}, expected one")
    for signal in loaded.config.limits:
        fault = signal_fault(descriptions, signal, ("output",))
        if fault is not None:
            problems.append(f"{loaded.where('limits', signal)}: {fault}")
