"""Faults of a case against its system: names, kinds of variables, bounds, units, slots."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from fmu_sources.composed import registry
from fmu_sources.composed.composition import all_slots
from fmu_sources.effects import catalogue as effects
from fmu_sources.effects.framework.roles import fits
from fmu_sources.framework.model import Slot
from master import catalogue
from master.errors import expected, shown
from master.fmi.description import Variable
from master.fmi.unit_names import unit
from master.fmi.values import parse
from master.system.graph import Instance, System
from master.text.signal_name import SignalName

from .carriers import port_slots
from .case import LoadedCase, RefitEntry

_KINDS = {
    "inputs": ("an input", ("input",)),
    "compared": ("an output", ("output", "local")),
    "refit": ("a parameter", ("parameter",)),
}


def faults(loaded: LoadedCase, system: System, sources: Mapping[str, str]) -> list[str]:
    """
    List all faults of a case that only its system shows.

    Args:
        loaded: The case.
        system: Its system.
        sources: Source of each FMU: name of a model, or file.
    """
    foreign = [name for name, source in sources.items() if catalogue.is_path(source)]
    slots = {name: _slots(source) for name, source in sources.items() if name not in foreign}
    of_ports = port_slots(loaded.case, system, [f for f in foreign if f in system.instances])
    return [
        *_names(loaded, system),
        *_windows(loaded, system),
        *_slot_faults(loaded, system, slots, of_ports),
        *_start_faults(loaded, system, slots),
        *_kinds(loaded, system),
        *_values(loaded, system),
        *_units(loaded, system),
        *_idle(loaded, system),
        *_of_recordings(loaded, system),
    ]


def _variable(system: System, signal: str) -> Variable | None:
    """Variable of a signal; None if there is none, or if its FMU could not be read."""
    name = SignalName(signal)
    instance = system.instances.get(name.instance)
    return None if instance is None else instance.description.by_name.get(name.variable)


def _names(loaded: LoadedCase, system: System) -> Iterator[str]:
    """Variables that do not exist."""
    case = loaded.case
    for part, signals in (
        ("inputs", case.inputs),
        ("compared", case.compared),
        ("refit", case.refit),
        ("set", case.set),
    ):
        for signal in signals:
            name, variable = SignalName(signal).instance, SignalName(signal).variable
            place = loaded.where(part, signal)
            if name not in system.descriptions:
                yield f"{place}: no such FMU, got {name!r}, {expected(name, system.descriptions)}"
            elif name in system.instances and _variable(system, signal) is None:
                known = system.instances[name].description.by_name
                yield f"{place}: no such variable, got {variable!r}, {expected(variable, known)}"


def _windows(loaded: LoadedCase, system: System) -> Iterator[str]:
    for name in loaded.case.replay.windows:
        if name not in system.descriptions:
            place = loaded.where("replay", "windows", name)
            yield f"{place}: no such FMU, got {name!r}, {expected(name, system.descriptions)}"


def _slots(source: str) -> dict[str, Slot]:
    """Slots of a model."""
    return {s.name: s for s in all_slots(registry.load(source))}


def _slot_faults(
    loaded: LoadedCase,
    system: System,
    slots: Mapping[str, Mapping[str, Slot]],
    of_ports: Mapping[str, Mapping[str, Sequence[Slot]]],
) -> Iterator[str]:
    for key, names in loaded.case.slots.items():
        fmu, name = SignalName(key).instance, SignalName(key).variable
        place = loaded.where("slots", key)
        if fmu in of_ports:
            if name not in of_ports[fmu]:
                ports = expected(name, of_ports[fmu]) if of_ports[fmu] else "which this FMU has none of"
                yield (
                    f"{place}: no slot at this port of a file, got {name!r}, expected a number that is named "
                    f"in `inputs` or `compared`, {ports}"
                )
            elif names != "all":
                yield from _effect_faults(place, of_ports[fmu][name], names)
        elif fmu not in slots:
            if fmu not in system.descriptions:
                yield f"{place}: no such FMU, got {fmu!r}, {expected(fmu, system.descriptions)}"
        elif name not in slots[fmu]:
            yield f"{place}: no such slot, got {name!r}, {expected(name, slots[fmu])}"
        elif names != "all":
            yield from _effect_faults(place, [slots[fmu][name]], names)


def _effect_faults(place: str, slots: Sequence[Slot], names: Iterable[str]) -> Iterator[str]:
    fitting = [e.name for e in effects.listed().values() if any(fits(e, slot) for slot in slots)]
    for name in names:
        if name not in effects.listed():
            yield f"{place}: no such effect, got {name!r}, {expected(name, fitting)}"
        elif name not in fitting:
            yield f"{place}: the slot has no signals for it, got {name!r}, {expected(name, fitting)}"


def _start_faults(
    loaded: LoadedCase, system: System, slots: Mapping[str, Mapping[str, Slot]]
) -> Iterator[str]:
    """Start values belong to variables of the system, or to states that an effect brings."""
    for key, (low, high) in loaded.case.starts.items():
        fmu, name = SignalName(key).instance, SignalName(key).variable
        place = loaded.where("starts", key)
        if not low < high:
            yield f"{place}: low is not below high, got {low!r} and {high!r}, expected [low, high]"
        if fmu not in system.instances:
            if fmu not in system.descriptions:
                yield f"{place}: no such FMU, got {fmu!r}, {expected(fmu, system.descriptions)}"
            continue
        known = [*system.instances[fmu].description.by_name]
        brought = [f"{slot}_{state}" for slot in slots.get(fmu, {}) for state in _states()]
        if name not in known and name not in brought:
            yield f"{place}: no such variable, got {name!r}, {expected(name, [*brought, *known])}"


def _states() -> list[str]:
    """States of all effects, as `effect_state`."""
    return [f"{e.name}_{x.name}" for e in effects.listed().values() for x in e.states]


def _kinds(loaded: LoadedCase, system: System) -> Iterator[str]:
    """Variables of another kind than their place asks for."""
    for part, (what, causalities) in _KINDS.items():
        for signal in getattr(loaded.case, part):
            variable = _variable(system, signal)
            if variable is not None and variable.causality not in causalities:
                got = f"{variable.causality} {signal}"
                yield f"{loaded.where(part, signal)}: not {what}, got {got}, expected {what}"


def _values(loaded: LoadedCase, system: System) -> Iterator[str]:
    for signal, value in loaded.case.set.items():
        variable = _variable(system, signal)
        if variable is None:
            continue
        try:
            parse(variable, value)
        except ValueError as error:
            yield f"{loaded.where('set', signal)}: value not allowed, got {shown(value)}, {error}"
    for signal, entry in loaded.case.refit.items():
        variable = _variable(system, signal)
        if variable is None:
            continue
        for fault in _bounds(entry, system.instances[SignalName(signal).instance], variable):
            yield f"{loaded.where('refit', signal)}: {fault}"


def _of_recordings(loaded: LoadedCase, system: System) -> Iterator[str]:
    """Values that a recording sets for itself."""
    for recording, entry in loaded.case.recordings.items():
        for signal, value in entry.set.items():
            place = loaded.where("recordings", recording, "set", signal)
            fmu, name = SignalName(signal).parts
            variable = _variable(system, signal)
            if fmu not in system.descriptions:
                yield f"{place}: no such FMU, got {fmu!r}, {expected(fmu, system.descriptions)}"
            elif variable is not None:
                try:
                    parse(variable, value)
                except ValueError as error:
                    yield f"{place}: value not allowed, got {shown(value)}, {error}"
            elif fmu in system.instances:
                known = system.instances[fmu].description.by_name
                yield f"{place}: no such variable, got {name!r}, {expected(name, known)}"


def _bounds(entry: RefitEntry, instance: Instance, variable: Variable) -> Iterator[str]:
    value = instance.value_of(variable.name)
    if isinstance(value, float) and not entry.low <= value <= entry.high:
        yield f"value of the system, got {value:g}, expected {entry.low:g} to {entry.high:g}, its bounds"
    if variable.minimum is not None and entry.low < variable.minimum:
        yield f"low, got {entry.low:g}, expected at least {variable.minimum:g}"
    if variable.maximum is not None and entry.high > variable.maximum:
        yield f"high, got {entry.high:g}, expected at most {variable.maximum:g}"


def _units(loaded: LoadedCase, system: System) -> Iterator[str]:
    """Signals with another unit than the FMU's variable; that of a rate is not declared."""
    measured = [(k, e.signal) for k, e in loaded.case.inputs.items()] + [*loaded.case.compared.items()]
    for key, signal in measured:
        entry = loaded.case.signals.get(signal)
        variable = _variable(system, key)
        if entry is None or entry.rate_of is not None or variable is None or variable.unit is None:
            continue
        try:
            found = unit(entry.unit)
        except ValueError:
            continue
        if found.exponents != variable.unit.exponents and entry.unit != "1":
            place = loaded.where("signals", signal, "unit")
            yield f"{place}: not the unit of {key}, got {entry.unit!r}, expected {variable.unit_name!r}"


def _idle(loaded: LoadedCase, system: System) -> Iterator[str]:
    """
    Inputs of single models that nothing drives and nobody gave a value to.

    In a system an input without a connection keeps its start value, as in a run.
    """
    case = loaded.case
    if case.system is not None:
        return
    replayed = {SignalName(key).instance for key in (*case.inputs, *case.compared)} & set(system.instances)
    driven = {
        *loaded.document.names_in("inputs"),
        *case.inputs,
        *case.set,
        *(w.target.name for w in system.wires),
    }
    driven |= {_primary(system, signal) for signal in driven}
    for name in sorted(replayed):
        instance = system.instances[name]
        for v in instance.description.variables:
            key = f"{name}.{v.name}"
            is_driven = key in driven or v.name in instance.start or v.alias_of is not None
            if v.causality == "input" and not is_driven:
                yield (
                    f"{loaded.where('inputs')}: {key} is not driven, expected a signal, or a value in `set` "
                    f"where none was measured"
                )


def _primary(system: System, signal: str) -> str:
    """Name of the variable that represents all that share a value with a signal; any other text unchanged."""
    try:
        return system.primary(signal).name
    except (KeyError, ValueError):
        return signal
