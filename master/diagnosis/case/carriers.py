"""
Slots for FMUs of which no model is known: a follower before each measured input, after each compared output.

The file of another tool has no slots in its equations. What passes its ports can still meet an effect: so
each input that was measured, and each output that is compared, is carried by a follower of gain 1, whose
slots take the effects. It steps within the same row as the file and costs no time. A force or a torque
whose motion was recorded too may meet a resistance, friction for one.

A user names such a slot by the port, `slots: {plant.force: all}`, and the report names it so.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from fmu_sources.composed.composition import SEPARATOR
from fmu_sources.effects import catalogue as effects
from fmu_sources.framework.model import Slot
from master.fmi.description import Description, Kind, Variable
from master.fmi.unit_names import unit
from master.fmi.units import Unit
from master.system.config import Config, Connection, FmuEntry
from master.system.graph import Instance, System
from master.text.signal_name import SignalName

from .case import Case, InputEntry, SignalEntry

STATIC = "static_follower"
MOVED = "moved_follower"
ANSWER = "answer"
RESISTANCE = "resistance"
POWER = {"kg": 1, "m": 2, "s": -3}  # of a force at a velocity
WORK = {"kg": 1, "m": 2, "s": -2}  # of a force along a way


@dataclass(frozen=True)
class Motion:
    """Signals of a case that are the motion at a force: position, where one is known, and velocity."""

    velocity: str
    position: str | None
    velocity_unit: str
    position_unit: str | None


@dataclass(frozen=True)
class Carrier:
    """
    A follower at a port of a foreign FMU; `name` is that of its instance.

    `signal` of the case is what was measured at the port, in `unit`. `is_scaled`: the FMU's own unit is
    another one, as `factor` and `offset` of SI say.
    """

    name: str
    fmu: str
    variable: str
    side: Literal["input", "output"]
    signal: str
    unit: str
    factor: float = 1.0
    offset: float = 0.0
    motion: Motion | None = None
    asked: Mapping[str, list[str]] = field(default_factory=dict)

    @property
    def port(self) -> str:
        """The port of the foreign FMU, as `fmu.variable`."""
        return f"{self.fmu}.{self.variable}"

    @property
    def source(self) -> str:
        """Name of the follower's model."""
        return STATIC if self.motion is None else MOVED

    @property
    def at_case(self) -> str:
        """What the case drives or compares in the place of the port."""
        return f"{self.name}.{'u' if self.side == 'input' else 'y'}"

    @property
    def slots(self) -> dict[str, Slot]:
        """Its slots by name, in the units of the port; without signals that nothing was recorded of."""
        found = {ANSWER: Slot(ANSWER, self.unit, f"What passes {self.port}")}
        if self.motion is not None:
            signals = {"der_q": self.motion.velocity_unit}
            if self.motion.position_unit is not None:
                signals = {"q": self.motion.position_unit, **signals}
            text = f"What resists the motion at {self.port}"
            found[RESISTANCE] = Slot(RESISTANCE, self.unit, text, signals)
        return found

    @property
    def is_late(self) -> bool:
        """Whether the speed at its force is that of the row where a step begins: it moves the FMU."""
        return self.side == "input" and self.motion is not None

    def described(self, description: Description) -> Description:
        """Describe the follower in the units of its port."""
        units = {"u": self.unit, "y": self.unit}
        variables = tuple(
            replace(v, unit=unit(units[v.name])) if v.name in units else v for v in description.variables
        )
        return replace(description, variables=variables)

    def spoken(self, text: str) -> str:
        """Name the port where a text names the follower's slots or signals."""
        text = re.sub(rf"\b{self.name}\.({ANSWER}|{RESISTANCE})\b", self.port, text)
        text = re.sub(rf"\b{self.name}\.({ANSWER}|{RESISTANCE})_", f"{self.port}_", text)
        return re.sub(rf"\b{self.name}\.[uy]\b", self.port, text)


def carriers_of(case: Case, system: System, foreign: Sequence[str]) -> list[Carrier]:
    """
    Followers for the measured inputs and the compared outputs of foreign FMUs.

    An FMU that the system connects to a follower itself keeps the slots that this gives it.
    """
    taken = set(system.instances)
    found: list[Carrier] = []
    for fmu in foreign:
        if _has_followers(system, fmu):
            continue
        ports = [(SignalName(k), e.signal, "input") for k, e in case.inputs.items()]
        ports += [(SignalName(k), signal, "output") for k, signal in case.compared.items()]
        for name, signal, side in ports:
            variable = _number(system, fmu, name)
            if variable is None:
                continue
            found.append(_carrier(case, system, variable, (fmu, name.variable, signal, side), taken))
            taken.add(found[-1].name)
    return found


def port_slots(case: Case, system: System, foreign: Sequence[str]) -> dict[str, dict[str, list[Slot]]]:
    """Slots at the ports of each foreign FMU, by FMU and port."""
    found: dict[str, dict[str, list[Slot]]] = {fmu: {} for fmu in foreign}
    for carrier in carriers_of(case, system, foreign):
        found[carrier.fmu][carrier.variable] = list(carrier.slots.values())
    return found


def carried_case(case: Case, carriers: Sequence[Carrier]) -> Case:
    """Return the case with the followers in the place of the ports that they carry."""
    inputs = dict(case.inputs)
    compared = dict(case.compared)
    slots: dict[str, Any] = dict(case.slots)
    fixed: dict[str, Any] = dict(case.set)
    for c in carriers:
        slots.pop(c.port, None)
        for slot in c.slots:
            slots[f"{c.name}.{slot}"] = c.asked[slot]
        own = inputs.get(c.port)
        if c.side == "input" and own is not None:
            inputs = _replaced(inputs, c.port, c.at_case, own)
        elif c.side == "output":
            compared = _replaced(compared, c.port, c.at_case, c.signal)
        if c.motion is not None:
            at = None if own is None else own.at
            for name, signal in (("q", c.motion.position), ("der_q", c.motion.velocity)):
                if signal is not None:
                    inputs[f"{c.name}.{name}"] = InputEntry(signal=signal, at=at)
                else:
                    fixed[f"{c.name}.{name}"] = 0.0
    return case.model_copy(update={"inputs": inputs, "compared": compared, "slots": slots, "set": fixed})


def carried_system(config: Config, carriers: Sequence[Carrier], case: Case, stepped: Sequence[str]) -> Config:
    """
    Return the system with the followers wired to their ports, each next to its FMU in the order.

    Args:
        config: The system.
        carriers: The followers.
        case: The case as it was written.
        stepped: FMUs in the order in which they step, where the system names none.
    """
    fmus = dict(config.fmus)
    connections = list(config.connections)
    for c in carriers:
        given: dict[str, Any] = {}
        if c.motion is not None and c.side == "input":
            given = {"side": -1.0}
        fmus[c.name] = FmuEntry(source=c.source, parameters=given)
        connections += _connections(c, case)
    order = list(config.coupling.order or stepped)
    for c in carriers:
        place = next(i for i, entry in enumerate(order) if _holds(entry, c.fmu))
        order.insert(place if c.side == "input" else place + 1, c.name)
    coupling = config.coupling.model_copy(update={"order": order})
    return config.model_copy(update={"fmus": fmus, "connections": connections, "coupling": coupling})


def _connections(c: Carrier, case: Case) -> Iterator[Connection]:
    """Wires of a follower: to or from its port, and of the motion of what its force moves."""
    if c.side == "output":
        yield _wire(c.port, f"{c.name}.u", c.factor, c.offset)
        return
    yield _wire(f"{c.name}.y", c.port, 1.0 / c.factor, -c.offset / c.factor)
    given = {} if c.motion is None else {"q": c.motion.position, "der_q": c.motion.velocity}
    for name, signal in given.items():  # cut in a replay, where it was measured; closed in a run
        for key, compared in case.compared.items():
            if signal == compared and SignalName(key).instance == c.fmu:
                yield _wire(key, f"{c.name}.{name}", 1.0, 0.0)
                break


def _wire(source: str, target: str, factor: float, offset: float) -> Connection:
    data = {"from": source, "to": target, "units": "ignored", "factor": factor, "offset": offset}
    return Connection.model_validate(data)


def _carrier(
    case: Case,
    system: System,
    variable: Variable,
    port: tuple[str, str, str, Any],
    taken: set[str],
) -> Carrier:
    fmu, name, signal, side = port
    told = _unit_of(case, signal)
    is_number = case.signals[signal].rate_of is None and case.signals[signal].unit == "1"
    own = variable.unit
    scaled = own is not None and not is_number  # a signal without unit is taken as it is
    motion = _motion(case, system, fmu, signal, side)
    shown = told if told is not None else own
    carrier = Carrier(
        name=_free_name(f"{fmu}_{name}", taken),
        fmu=fmu,
        variable=name,
        side=side,
        signal=signal,
        unit=_coherent(shown),
        factor=own.factor if scaled and own is not None else 1.0,
        offset=own.offset if scaled and own is not None else 0.0,
        motion=motion,
    )
    asked = {
        slot.name: [e.name for e in effects.listed().values() if _is_asked(case, carrier, e.name, slot)]
        for slot in carrier.slots.values()
    }
    if RESISTANCE in asked:  # an offset in both is one offset
        asked[RESISTANCE] = [e for e in asked[RESISTANCE] if e not in asked[ANSWER]]
    return replace(carrier, asked=asked)


def _is_asked(case: Case, carrier: Carrier, effect: str, slot: Slot) -> bool:
    """Whether an effect fits a slot and the case wants it there; all of them if it names none of the FMU."""
    if effects.effect(effect) not in effects.candidates(slot):
        return False
    named = {k: v for k, v in case.slots.items() if SignalName(k).instance == carrier.fmu}
    if not named:
        return True
    own = named.get(carrier.port)
    return own is not None and (own == "all" or effect in own)


def _number(system: System, fmu: str, name: SignalName) -> Variable | None:
    """A port that carries a real number of its own; None otherwise."""
    if name.instance != fmu:
        return None
    variable = system.instances[fmu].description.by_name[name.variable]
    return variable if variable.kind is Kind.REAL else None


def _has_followers(system: System, fmu: str) -> bool:
    """Whether the system connects an FMU to a follower itself, whose slots are its own."""
    own = {name for name, i in system.instances.items() if _is_follower(i)}
    ends = [(w.source.instance, w.target.instance) for w in system.wires]
    return any(fmu in pair and own & set(pair) for pair in ends)


def hands_on(instance: Instance, given: str, made: str) -> bool:
    """Whether an output follows an input within the row; a follower says so of its initial values alone."""
    return instance.description.hands_through(given, made) or _is_follower(instance)


def _is_follower(instance: Instance) -> bool:
    return instance.description.model_name.partition(SEPARATOR)[0] in (STATIC, MOVED)


def _motion(case: Case, system: System, fmu: str, signal: str, side: str) -> Motion | None:
    """
    The motion at a force, by the units: force times velocity is a power, force times way a work.

    It is among the other ports of the FMU: what drives it, for a force that it gives, and what it gives, for
    a force that drives it. Where several signals may be the velocity, none is taken.
    """
    force = _unit_of(case, signal)
    if force is None or force.exponents == {} or not _is_force(force):
        return None
    ports = case.inputs.items() if side == "output" else case.compared.items()
    others = [
        value.signal if isinstance(value, InputEntry) else value
        for key, value in ports
        if SignalName(key).instance == fmu
    ]
    velocities = _of_dimension(case, others, force, POWER)
    if len(velocities) != 1:
        return None
    positions = _of_dimension(case, others, force, WORK)
    velocity = velocities[0]
    position = positions[0] if len(positions) == 1 else None
    return Motion(
        velocity=velocity,
        position=position,
        velocity_unit=_coherent(_unit_of(case, velocity)),
        position_unit=None if position is None else _coherent(_unit_of(case, position)),
    )


def _is_force(force: Unit) -> bool:
    exponents = dict(force.exponents)
    exponents.pop("rad", None)
    return exponents in ({"kg": 1, "m": 1, "s": -2}, {"kg": 1, "m": 2, "s": -2})


def _of_dimension(case: Case, signals: Sequence[str], force: Unit, product: Mapping[str, int]) -> list[str]:
    """Signals, each once, that give with a force a product of some dimension; angles count as none."""
    found = []
    for name in dict.fromkeys(signals):
        told = _unit_of(case, name)
        if told is None:
            continue
        total = dict(force.exponents)
        for base, power in told.exponents.items():
            total[base] = total.get(base, 0) + power
        total.pop("rad", None)
        if {base: power for base, power in total.items() if power} == product:
            found.append(name)
    return found


def _unit_of(case: Case, signal: str) -> Unit | None:
    """Unit of a signal of the case, of a rate by what it is the rate of; None where none is told."""
    entry: SignalEntry | None = case.signals.get(signal)
    seconds = 0
    for _ in case.signals:
        if entry is None or entry.rate_of is None:
            break
        entry = case.signals.get(entry.rate_of)
        seconds += 1
    if entry is None or entry.rate_of is not None or entry.unit == "1":
        return None
    try:
        return unit(entry.unit + seconds * "/s")
    except ValueError:  # told with the other faults of the case
        return None


_NAMES = (
    *("1", "N", "N m", "m", "m/s", "m/s2", "rad", "rad/s", "rad/s2", "Pa", "V", "A", "W", "K", "kg", "Hz"),
    *("m3/s", "m2", "m3", "N s/m", "N/m"),
)


def _coherent(of: Unit | None) -> str:
    """Name of the SI unit without a factor that has the dimensions of another one; `1` where none is told."""
    exponents = {} if of is None else {base: n for base, n in of.exponents.items() if n}
    known = next((name for name in _NAMES if dict(unit(name).exponents) == exponents), None)
    if known is not None:
        return known
    above = [_power(base, n) for base, n in exponents.items() if n > 0]
    below = [_power(base, -n) for base, n in exponents.items() if n < 0]
    divisor = f"({' '.join(below)})" if len(below) > 1 else "".join(below)
    return " ".join(above or ["1"]) + (f"/{divisor}" if below else "")


def _power(base: str, n: int) -> str:
    return base if n == 1 else f"{base}{n}"


def _replaced(inputs: Mapping[str, Any], old: str, new: str, value: Any) -> dict[str, Any]:
    """A mapping with another key in the place of an old one."""
    return {new if key == old else key: value if key == old else own for key, own in inputs.items()}


def _holds(entry: Any, fmu: str) -> bool:
    """Whether an entry of an order is an FMU, or has it in a group."""
    data = entry.model_dump() if hasattr(entry, "model_dump") else entry
    if isinstance(data, Mapping):
        return any(_holds(value, fmu) for value in data.values())
    if isinstance(data, list | tuple):
        return any(_holds(value, fmu) for value in data)
    return bool(data == fmu)


def _free_name(wanted: str, taken: Collection[str]) -> str:
    """A name of an instance that is not taken."""
    plain = re.sub(r"\W+", "_", wanted).strip("_")
    name = plain
    number = 2
    while name in taken:
        name = f"{plain}_{number}"
        number += 1
    return name
