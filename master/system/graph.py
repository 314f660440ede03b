"""Structure of a system: instances, ports, units and wires, checked as a whole. No FMU is loaded."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from master.errors import ConfigError, Problem, nearest
from master.fmi.description import Description, Kind, Variable
from master.fmi.structure import with_structure
from master.fmi.units import Conversion, conversion
from master.fmi.values import settable
from master.text.scalar import Setting
from master.text.signal_name import SignalName

from .config import Connection, LoadedConfig

Descriptions = Mapping[str, Description | None]
"""By instance name; None where the FMU could not be read, so that nothing is said of its variables."""


@dataclass(frozen=True)
class Instance:
    """One FMU of the system with the values it starts from, by the names of primary variables."""

    name: str
    description: Description
    every: int
    start: Mapping[str, float | str]

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
    """

    instances: Mapping[str, Instance]
    wires: tuple[Wire, ...]
    unread: tuple[str, ...] = ()

    @property
    def descriptions(self) -> dict[str, Description | None]:
        """Description of each FMU by instance name."""
        known = {name: i.description for name, i in self.instances.items()}
        return known | dict.fromkeys(self.unread)

    @cached_property
    def _into(self) -> dict[str, list[Wire]]:
        ending: dict[str, list[Wire]] = {name: [] for name in self.instances}
        for wire in self.wires:
            ending[wire.target.instance].append(wire)
        return ending

    def wires_into(self, instance: str) -> list[Wire]:
        """Wires that end at an instance."""
        return self._into[instance]

    def port(self, signal: str) -> Port:
        """Find `instance.variable`; KeyError if there is none."""
        name = SignalName(signal)
        return Port(name.instance, self.instances[name.instance].description.by_name[name.variable])

    def primary(self, signal: str) -> Port:
        """Find the primary variable of those that share a value with `instance.variable`, as `port` does."""
        name = SignalName(signal)
        return Port(name.instance, self.instances[name.instance].description.primary(name.variable))


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
    wires = _wires(loaded, descriptions, problems)
    connected = {w.target.name for w in wires}
    instances = {
        name: Instance(name, d, loaded.config.fmus[name].every, _start(loaded, name, d, connected, problems))
        for name, d in descriptions.items()
        if d is not None
    }
    unread = tuple(name for name, d in descriptions.items() if d is None)
    for signal, (where, value) in overrides.items():
        fault = _override(instances, signal, value, connected, unread)
        problems += [] if fault is None else [f"{where}: {fault}"]
    problems += _variant_faults(loaded, instances, connected, unread)
    _check_signals(loaded, descriptions, problems)
    return System(instances, tuple(wires), unread), problems


def _with_structures(
    loaded: LoadedConfig,
    descriptions: Descriptions,
    overrides: Mapping[str, tuple[str, Setting]],
    problems: list[str],
) -> Descriptions:
    """Give arrays the sizes that the values of structural parameters ask for."""
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


def _variant_faults(
    loaded: LoadedConfig, instances: Mapping[str, Instance], connected: set[str], unread: tuple[str, ...]
) -> list[str]:
    """Faults of all variants, chosen or not; a variant may give arrays other sizes."""
    faults: list[str] = []
    for variant, fmus in loaded.config.variants.items():
        for name, values in fmus.items():
            own = dict(instances)
            try:
                if name in own:
                    own[name] = replace(own[name], description=with_structure(own[name].description, values))
            except ConfigError as error:
                faults += [p.at(loaded.where("variants", variant, name)) for p in error.problems]
                continue
            for key, value in values.items():
                fault = _override(own, f"{name}.{key}", value, connected, unread)
                if fault is not None:
                    faults.append(f"{loaded.where('variants', variant, name, key)}: {fault}")
    return faults


def _override(
    instances: dict[str, Instance], signal: str, value: Setting, connected: set[str], unread: tuple[str, ...]
) -> str | None:
    """Set one value over those of the file; return what is wrong with it."""
    name, key = SignalName(signal).parts
    if name in unread:
        return None
    if name not in instances:
        return Problem("no such FMU", got=repr(name), expected=nearest(name, instances))
    instance = instances[name]
    try:
        parsed = settable(instance.description, name, key, value, connected)
    except ValueError as error:
        return str(error)
    instances[name] = replace(instance, start={**instance.start, **parsed})
    return None


def _wires(loaded: LoadedConfig, descriptions: Descriptions, problems: list[str]) -> list[Wire]:
    wires: list[Wire] = []
    first: dict[str, tuple[int, str]] = {}
    for i, connection in _scalars(loaded, descriptions, problems):
        source = _port(loaded, descriptions, i, "from", connection.source, problems)
        target = _port(loaded, descriptions, i, "to", connection.target, problems)
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
    if Kind.STRING in (source.variable.kind, target.variable.kind):
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


_ALLOWED = {"from": ("output",), "to": ("input",)}


def _port(
    loaded: LoadedConfig,
    descriptions: Descriptions,
    i: int,
    end: str,
    signal: str,
    problems: list[str],
) -> Port | None:
    fault = signal_fault(descriptions, signal, _ALLOWED[end])
    if fault is not None:
        problems.append(f"{loaded.where('connections', i, end)}: {fault}")
        return None
    name = SignalName(signal)
    description = descriptions[name.instance]
    if description is None:
        return None
    variable = description.by_name[name.variable] if end == "from" else description.primary(name.variable)
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


def _check_signals(loaded: LoadedConfig, descriptions: Descriptions, problems: list[str]) -> None:
    compare = loaded.config.compare
    named = {} if compare is None else {k: v for k, v in compare.model_dump().items() if isinstance(v, str)}
    for key, signal in named.items():
        fault = signal_fault(descriptions, signal, ("output",))
        if fault is not None:
            problems.append(f"{loaded.where('compare', key)}: {fault}")
    for signal in loaded.config.limits:
        fault = signal_fault(descriptions, signal, ("output",))
        if fault is not None:
            problems.append(f"{loaded.where('limits', signal)}: {fault}")
