"""Structure of a system: instances, ports, units and wires, checked as a whole. No FMU is loaded."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from master.errors import ConfigError, expected
from master.fmi.description import Description, Kind, Variable
from master.fmi.units import Conversion, conversion
from master.fmi.value_types import Value
from master.fmi.values import parse, settable

from .config import Connection, LoadedConfig


@dataclass(frozen=True)
class Instance:
    """One FMU of the system with the values it starts from."""

    name: str
    description: Description
    every: int
    start: Mapping[str, float | str]

    def value_of(self, name: str) -> float | str | None:
        """Value of a parameter or start value: the configured one or the FMU's own."""
        if name in self.start:
            return self.start[name]
        variable = self.description.by_name.get(name)
        if variable is None or variable.start is None:
            return None
        return parse(variable, variable.start)


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
    A connection between two ports that fit.

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
    """Instances by name in the order of the file, and the wires between them."""

    instances: Mapping[str, Instance]
    wires: tuple[Wire, ...]

    def wires_into(self, instance: str) -> list[Wire]:
        """Wires that end at an instance."""
        return [w for w in self.wires if w.target.instance == instance]

    def port(self, signal: str) -> Port:
        """Find `instance.variable`; KeyError if there is none."""
        instance, _, variable = signal.partition(".")
        return Port(instance, self.instances[instance].description.by_name[variable])


def build_system(
    loaded: LoadedConfig, descriptions: Mapping[str, Description], overrides: Mapping[str, tuple[str, Value]]
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
    problems: list[str] = []
    wires = _wires(loaded, descriptions, problems)
    connected = {w.target.name for w in wires}
    instances = {
        name: Instance(name, d, loaded.config.fmus[name].every, _start(loaded, name, d, connected, problems))
        for name, d in descriptions.items()
    }
    for signal, (where, value) in overrides.items():
        fault = _override(instances, signal, value, connected)
        problems += [] if fault is None else [f"{where}: {fault}"]
    problems += _variant_faults(loaded, instances, connected)
    _check_signals(loaded, descriptions, problems)
    if problems:
        raise ConfigError(dict.fromkeys(problems))
    return System(instances, tuple(wires))


def _start(
    loaded: LoadedConfig, name: str, d: Description, connected: set[str], problems: list[str]
) -> dict[str, float | str]:
    entry = loaded.config.fmus[name]
    values: dict[str, float | str] = {}
    for section, given in (("parameters", entry.parameters), ("start", entry.start)):
        for key, value in given.items():
            where = loaded.where("fmus", name, section, key)
            try:
                values[key] = settable(d, name, key, value, connected)
            except ValueError as error:
                problems.append(f"{where}: {error}")
    return values


def _variant_faults(
    loaded: LoadedConfig, instances: Mapping[str, Instance], connected: set[str]
) -> list[str]:
    """Faults of all variants, chosen or not."""
    entries = (
        (loaded.where("variants", variant, name, key), f"{name}.{key}", value)
        for variant, fmus in loaded.config.variants.items()
        for name, values in fmus.items()
        for key, value in values.items()
    )
    faults = (
        (where, _override(dict(instances), signal, value, connected)) for where, signal, value in entries
    )
    return [f"{where}: {fault}" for where, fault in faults if fault is not None]


def _override(instances: dict[str, Instance], signal: str, value: Value, connected: set[str]) -> str | None:
    """Set one value over those of the file; give what is wrong with it."""
    name, _, key = signal.partition(".")
    if name not in instances:
        return f"no such FMU, got {name!r}, {expected(name, instances)}"
    instance = instances[name]
    try:
        parsed = settable(instance.description, name, key, value, connected)
    except ValueError as error:
        return str(error)
    instances[name] = replace(instance, start={**instance.start, key: parsed})
    return None


def _wires(loaded: LoadedConfig, descriptions: Mapping[str, Description], problems: list[str]) -> list[Wire]:
    wires: list[Wire] = []
    first: dict[str, int] = {}
    for i, connection in _scalars(loaded, descriptions, problems):
        source = _port(loaded, descriptions, i, "from", connection.source, problems)
        target = _port(loaded, descriptions, i, "to", connection.target, problems)
        if connection.target in first:
            problems.append(
                f"{loaded.where('connections', i, 'to')}: has two sources, got {connection.target!r} "
                f"again, expected one connection (the other is connections[{first[connection.target]}])"
            )
            continue
        first[connection.target] = i
        if source is not None and target is not None:
            wires += _wire(loaded, i, connection, source, target, problems)
    return wires


def _scalars(
    loaded: LoadedConfig, descriptions: Mapping[str, Description], problems: list[str]
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


def _elements(descriptions: Mapping[str, Description], signal: str) -> list[str]:
    """Signals of the elements of a whole array; empty for anything else."""
    instance, _, variable = signal.partition(".")
    if instance not in descriptions:
        return []
    return [f"{instance}.{v.name}" for v in descriptions[instance].arrays.get(variable, ())]


def _place(element: str) -> str:
    return "[" + element.rpartition("[")[2]


def _wire(
    loaded: LoadedConfig, i: int, c: Connection, source: Port, target: Port, problems: list[str]
) -> list[Wire]:
    found = conversion(source.variable.unit, target.variable.unit)
    if found is None:
        problems.append(
            f"{loaded.where('connections', i)}: units differ, "
            f"got {_with_unit(source)} -> {_with_unit(target)}, expected the same quantity"
        )
        return []
    if Kind.STRING in (source.variable.kind, target.variable.kind):
        problems.append(f"{loaded.where('connections', i)}: strings cannot be connected, got {source.name}")
        return []
    return [Wire(source, target, c.delay, found, c.extrapolation, c.tolerance)]


def _with_unit(port: Port) -> str:
    return f"{port.name} [{port.variable.unit_name}]"


_ALLOWED = {"from": ("output",), "to": ("input",)}


def _port(
    loaded: LoadedConfig,
    descriptions: Mapping[str, Description],
    i: int,
    end: str,
    signal: str,
    problems: list[str],
) -> Port | None:
    fault = signal_fault(descriptions, signal, _ALLOWED[end])
    if fault is not None:
        problems.append(f"{loaded.where('connections', i, end)}: {fault}")
        return None
    instance, _, variable = signal.partition(".")
    return Port(instance, descriptions[instance].by_name[variable])


def signal_fault(
    descriptions: Mapping[str, Description], signal: str, causalities: tuple[str, ...] | None
) -> str | None:
    """Say what is wrong with `instance.variable`; None if it exists with one of the causalities."""
    instance, _, variable = signal.partition(".")
    if instance not in descriptions:
        return f"no such FMU, got {instance!r}, {expected(instance, descriptions)}"
    d = descriptions[instance]
    names = [v.name for v in d.variables if causalities is None or v.causality in causalities]
    if variable in names:
        return None
    if variable in d.not_exchanged:
        return f"cannot be exchanged, got {signal} ({d.not_exchanged[variable]}), {expected(variable, names)}"
    what = "variable" if causalities is None else " or ".join(causalities)
    return f"no such {what} of {instance} ({d.model_name}), got {variable!r}, {expected(variable, names)}"


def _check_signals(
    loaded: LoadedConfig, descriptions: Mapping[str, Description], problems: list[str]
) -> None:
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
