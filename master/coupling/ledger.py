"""
The delay ledger: how old each value is when it is used, for every connection and every loop.

`steps` is what the coupling adds: the number of rows between the row in which a value appears at
its source and the row whose outputs of the target depend on it (0 if the source steps before the
target, 1 if not, within a group what its method says; plus the connection's delay; an FMU at every
n-th tick, or a window of ticks, makes it a range). A mark
sent through a connection shows exactly this number. `own` is what the target declares of itself
beyond that: the way it holds an input, its integrator, dead time, lag.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice
from math import gcd

from master.fmi.description import DeclaredDelay, Description
from master.system.graph import Instance, System, Wire

from . import extrapolation
from .loops import closed_paths
from .schedule import Schedule

MOST_LOOPS = 1000


@dataclass(frozen=True)
class OwnDelay:
    """A delay inside the target FMU [s]; negative: the value is used as one of an earlier instant."""

    kind: str
    seconds: float
    reason: str


@dataclass(frozen=True)
class Entry:
    """One connection; `least` and `most` differ if an FMU steps every n-th tick only."""

    source: str
    target: str
    least: int
    most: int
    step_size: float
    own: tuple[OwnDelay, ...]

    @property
    def mean(self) -> float:
        """Mean age in steps."""
        return 0.5 * (self.least + self.most)

    @property
    def seconds(self) -> float:
        """Mean age with all that the target adds [s]."""
        return self.mean * self.step_size + sum(o.seconds for o in self.own)


@dataclass(frozen=True)
class Loop:
    """A closed path over connections, and the sum of their delays."""

    entries: tuple[Entry, ...]

    @property
    def path(self) -> list[str]:
        """Signals along the loop."""
        return [e.source for e in self.entries]

    @property
    def steps(self) -> float:
        """Sum of the mean ages in steps."""
        return sum(e.mean for e in self.entries)

    @property
    def seconds(self) -> float:
        """Sum with what the FMUs declare [s]."""
        return sum(e.seconds for e in self.entries)


@dataclass(frozen=True)
class Ledger:
    """All connections and all loops of a scheduled system; not `complete` beyond MOST_LOOPS loops."""

    entries: tuple[Entry, ...]
    loops: tuple[Loop, ...]
    complete: bool = True


def make_ledger(system: System, schedule: Schedule, step_size: float) -> Ledger:
    """Compute the ledger of a scheduled system; `step_size` in s."""
    entries = tuple(_entry(system, schedule, wire, step_size) for wire in system.wires)
    let_out = tuple(_let_out(schedule, wire, step_size) for wire in system.outlets)
    paths = closed_paths(system, Description.reaches)
    found = tuple(islice(paths, MOST_LOOPS + 1))
    loops = tuple(Loop(tuple(entries[i] for i in path)) for path in found[:MOST_LOOPS])
    return Ledger((*entries, *let_out), loops, complete=len(found) <= MOST_LOOPS)


def steps_of(schedule: Schedule, wire: Wire) -> tuple[int, int]:
    """Least and largest age in steps that the coupling gives a connection."""
    every_source, every_target = schedule.every[wire.source.instance], schedule.every[wire.target.instance]
    return _rates(schedule.age(wire) + wire.delay, every_source, every_target)


def _rates(base: int, source: int, target: int) -> tuple[int, int]:
    """
    Range of ages over one common period of the two rates: a value is held until its source's next step.

    The target uses at row k, a multiple of its rate, the value of row k - base, whose source stepped
    (k - base) mod source rows before; k runs through all multiples of the common divisor of the rates.
    """
    divisor = gcd(source, target)
    least = base + -base % divisor
    return least, least + source - divisor


def _entry(system: System, schedule: Schedule, wire: Wire, step_size: float) -> Entry:
    least, most = steps_of(schedule, wire)
    target = system.instances[wire.target.instance]
    shown = _own_delays(target, wire.target.variable.name, step_size)
    if wire.extrapolation:
        gained = extrapolation.gained_steps(wire.extrapolation) * target.every * step_size
        shown += (OwnDelay("extrapolation", -gained, extrapolation.reason(wire.extrapolation)),)
    return Entry(wire.source.name, wire.target.name, least, most, step_size, shown)


def _let_out(schedule: Schedule, wire: Wire, step_size: float) -> Entry:
    """Return the entry of an output of the whole system: it is read after each tick."""
    least, most = _rates(0, schedule.every.get(wire.source.instance, 1), 1)
    return Entry(wire.source.name, wire.target.name, least, most, step_size, ())


def input_entry(system: System, source: str, target: str, age: int, step_size: float) -> Entry:
    """Return the entry of an input that a recording drives, whose values are some ticks old when used."""
    name, _, variable = target.partition(".")
    instance = system.instances.get(name)  # none for an output of the whole system
    own = () if instance is None else _own_delays(instance, variable, step_size)
    return Entry(source, target, age, age, step_size, own)


def _own_delays(target: Instance, variable: str, step_size: float) -> tuple[OwnDelay, ...]:
    own = (
        _own(target, d, step_size * target.every) for d in target.description.delays if d.input == variable
    )
    return tuple(o for o in own if o.seconds)


def _own(target: Instance, delay: DeclaredDelay, step: float) -> OwnDelay:
    steps = delay.steps if delay.by is None else delay.cases.get(_item(target, delay.by), 0.0)
    try:
        seconds = float(delay.seconds)
    except ValueError:
        seconds = float(target.value_of(delay.seconds) or 0.0)
    return OwnDelay(delay.kind, (steps or 0.0) * step + seconds, delay.reason)


def _item(target: Instance, choice: str) -> str:
    """Name of the item that a choice parameter has."""
    value = target.value_of(choice)
    items = target.description.by_name[choice].items
    return next((name for name, number in items.items() if number == value), "")
