"""
A scenario: what happens to values and connections during a run, at a time or when a condition comes true.

A fault of the measuring chain acts on a connected input through its channel: `freeze` holds the last
value, `drop` gives the FMU's own start value, `offset` adds, `delay` and `jitter` age the value by
whole ticks. `set` changes a tunable parameter or an input that is not connected. The name of an array (FMI
3.0) is that of all of its elements. A run ends where a condition of `stop_when` comes true.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from master.errors import ConfigError, Problem, shown
from master.fmi.description import Kind, Variable
from master.fmi.values import named_by, parse, spread
from master.text.fields import finite
from master.text.scalar import Value, float_of
from master.text.signal_name import SignalName

from .channel import DELAY, DROP, FREEZE, JITTER, MODE, OFFSET, RANDOM
from .config import Event, LoadedConfig
from .graph import System, handed, signal_fault
from .grid import Grid

_DEEDS = ("set", "offset", "freeze", "drop", "delay", "jitter")
_MOST_LISTED = 30
_SIGN = re.compile(r"\s*[<>]\s*")


@dataclass(frozen=True)
class Condition:
    """`signal > threshold` or `signal < threshold` (sign -1)."""

    signal: str
    sign: float
    threshold: float

    def holds(self, value: float) -> bool:
        """Whether it is true for a value of the signal."""
        return self.sign * (value - self.threshold) > 0.0

    def __str__(self) -> str:
        return f"{self.signal} {'>' if self.sign > 0.0 else '<'} {self.threshold:g}"


@dataclass(frozen=True)
class Action:
    """One change of one target; `columns` are cells of the connection's channel, `value` that of `set`."""

    target: str
    columns: Mapping[int, float] = field(default_factory=dict)
    value: float | None = None


@dataclass(frozen=True)
class ScenarioEvent:
    """Actions at a time [s] or under a condition, taken back after `duration` [s] if there is one."""

    actions: tuple[Action, ...]
    at: float | None
    condition: Condition | None
    duration: float | None


@dataclass(frozen=True)
class Scenario:
    """All events of a run, and the conditions that end it."""

    events: tuple[ScenarioEvent, ...] = ()
    stops: tuple[Condition, ...] = ()

    def channels(self) -> dict[str, int]:
        """Connected inputs that events act on, with the most ticks that their values may age."""
        longest: dict[str, int] = {}
        for action in (a for e in self.events for a in e.actions if a.value is None):
            age = int(action.columns.get(DELAY, 0.0) + action.columns.get(JITTER, 0.0))
            longest[action.target] = max(longest.get(action.target, 0), age)
        return longest


def make_scenario(loaded: LoadedConfig, system: System) -> Scenario:
    """
    Check the events of a configuration, and what ends its run, against its system.

    Raises:
        ConfigError: With every fault.
    """
    config = loaded.config
    problems: list[Problem] = []
    events = []
    grid = Grid(config.start_time, config.step_size, config.n_ticks)
    for i, event in enumerate(config.events):
        where = loaded.where("events", i)
        if event.at is not None and not config.start_time <= event.at < config.stop_time:
            problems.append(
                Problem(
                    "not within the run",
                    where=where,
                    got=f"at {event.at:.15g} s",
                    expected=f"from {config.start_time:.15g} s to before {config.stop_time:.15g} s",
                )
            )
        elif event.at is not None and grid.tick_at(event.at) >= grid.n_ticks:
            problems.append(
                Problem(
                    "after the begin of the last step, so that it would not act",
                    where=where,
                    got=f"at {event.at:.15g} s",
                    expected=f"at most {grid.time(grid.n_ticks - 1):.15g} s",
                )
            )
        reader = _EventReader(event, system)
        events.append(reader.event())
        problems += [problem.at(where) for problem in reader.problems]
    stops = []
    for i, text in enumerate(config.stop_when):
        try:
            stops.append(read_condition(text, system, or_signal=True))
        except ConfigError as error:
            problems += [problem.at(loaded.where("stop_when", i)) for problem in error.problems]
    if problems:
        raise ConfigError(problems)
    return Scenario(tuple(events), tuple(stops))


def read_condition(text: str, system: System, *, or_signal: bool = False) -> Condition:
    """
    Read `instance.variable > number`; with `or_signal` also a signal alone, true where it is above 0.

    Raises:
        ConfigError: With every fault.
    """
    parts = _parts_of(text)
    if parts is None and or_signal:
        parts = _Parts(text.strip(), ">", "0")
    if parts is None:
        wanted = "'instance.variable > number'"
        raise ConfigError([Problem("not a condition", got=shown(text), expected=wanted)])
    fault = signal_fault(system.descriptions, parts.signal, ("output",))
    problems = [] if fault is None else [fault]
    threshold = 0.0
    try:
        threshold = finite(float_of(parts.number))
    except ValueError:
        problems.append(Problem("not a number", got=shown(parts.number), expected="a threshold"))
    if problems:
        raise ConfigError(problems)
    return Condition(parts.signal, 1.0 if parts.sign == ">" else -1.0, threshold)


class _Parts(NamedTuple):
    """What a condition is written of."""

    signal: str
    sign: str
    number: str


def _parts_of(text: str) -> _Parts | None:
    """
    Cut a condition into signal, sign and number.

    The sign is the last one, since names of variables may hold signs; None if there is none.
    """
    signs = list(_SIGN.finditer(text))
    if not signs:
        return None
    last = signs[-1]
    signal, number = text[: last.start()].strip(), text[last.end() :].strip()
    return _Parts(signal, last[0].strip(), number) if signal and number else None


class _EventReader:
    """Makes one event, and collects what is wrong with it."""

    def __init__(self, event: Event, system: System) -> None:
        self.given = event
        self.system = system
        self.descriptions = system.descriptions
        self.connected = [w.target.name for w in system.wires]
        self.problems: list[Problem] = []

    def event(self) -> ScenarioEvent:
        """Return the event without what is wrong with it."""
        given = self.given
        condition = None if given.when is None else self._condition(given.when)
        actions = [
            *self._set_actions(),
            *self._channel_actions(given.freeze, {MODE: FREEZE}),
            *self._channel_actions(given.drop, {MODE: DROP}),
        ]
        for target, amount in given.offset.items():
            if self._bears_offset(self._elements(target)[0], amount):
                actions += self._channel_actions([target], {OFFSET: amount})
        for target, ticks in given.delay.items():
            actions += self._channel_actions([target], {DELAY: float(ticks)})
        for target, ticks in given.jitter.items():
            jitter = {JITTER: float(ticks), RANDOM: float(given.seed)}
            actions += self._channel_actions([target], jitter)
        if not any(getattr(given, deed) for deed in _DEEDS):
            self._add("does nothing", expected=f"one of {', '.join(_DEEDS)}")
        return ScenarioEvent(tuple(actions), given.at, condition, given.duration)

    def _add(self, what: str, *, where: str = "", got: str = "", expected: str = "") -> None:
        self.problems.append(Problem(what, where=where, got=got, expected=expected))

    def _condition(self, text: str) -> Condition | None:
        try:
            return read_condition(text, self.system)
        except ConfigError as error:
            self.problems += [problem.at("when") for problem in error.problems]
            return None

    def _variable(self, target: str) -> Variable | None:
        """Return the primary variable of a target; None if there is none or its FMU could not be read."""
        name = SignalName(target)
        description = self.descriptions.get(name.instance)
        if description is None or name.variable not in description.by_name:
            return None
        return description.primary(name.variable)

    def _reached(self, target: str) -> str:
        """Signal whose value an action on a target changes: that of the primary variable."""
        variable = self._variable(target)
        return target if variable is None else f"{SignalName(target).instance}.{variable.name}"

    def _bears_offset(self, target: str, amount: float) -> bool:
        """Refuse an offset of a Boolean, which means nothing, and a part of one on an integer."""
        variable = self._variable(target)
        if variable is None:
            return True
        if variable.kind is Kind.BOOLEAN:
            self._add(
                f"{target} is a Boolean", where="offset", expected="freeze, drop, delay or jitter for it"
            )
        elif variable.kind is Kind.INTEGER and not amount.is_integer():
            got = f"{amount:g}"
            self._add(f"{target} is an integer", where="offset", got=got, expected="a whole number")
        else:
            return True
        return False

    def _elements(self, target: str) -> list[str]:
        """Signals that a target is: the elements of an array, or itself."""
        name = SignalName(target)
        description = self.descriptions.get(name.instance)
        variables = () if description is None else named_by(description, name.variable)
        return [f"{name.instance}.{v.name}" for v in variables] or [target]

    def _set_actions(self) -> Iterator[Action]:
        for target, value in self.given.set.items():
            fault = signal_fault(self.descriptions, self._elements(target)[0], ("parameter", "input"))
            if fault is not None:
                self.problems.append(fault.at("set"))
                continue
            name = SignalName(target)
            description = self.descriptions[name.instance]
            if description is None:
                continue
            try:
                pairs = spread(description, name.variable, value)
            except ValueError as error:
                self.problems.append(Problem.of_line(f"set: {target}: {error}"))
                continue
            for variable, one in pairs:
                primary = description.primary(variable.name)
                yield from self._set(f"{name.instance}.{variable.name}", primary, one)

    def _set(self, target: str, variable: Variable, value: Value) -> Iterator[Action]:
        if self._reached(target) in self.connected:
            self._add(f"{target} is connected", where="set", expected="offset, freeze or drop for it")
        elif variable.kind is Kind.STRING:
            self._add(f"{target} is a string", where="set", expected="a number or a Boolean during a run")
        elif variable.causality == "parameter" and variable.variability != "tunable":
            self._add(f"{target} is fixed during a run", where="set", expected="a tunable parameter")
        else:
            try:
                parsed = parse(variable, value)
                assert not isinstance(parsed, str)
                yield from self._reach(self._reached(target), parsed)
            except ValueError as error:
                problem = Problem.of_line(f"set: {target}: value not allowed, got {shown(value)}, {error}")
                self.problems.append(problem)

    def _reach(self, target: str, value: float) -> Iterator[Action]:
        """Act on a target itself, or on all that an input of the whole system leads to."""
        if SignalName(target).instance not in self.system.connectors:
            yield Action(target, value=value)
            return
        wires = self.system.driven_by(target)
        if not wires:
            self._add(f"{target} leads to no FMU", where="set", expected="a connected input")
        for wire in wires:
            carried = handed(wire, value)
            assert not isinstance(carried, str)
            if wire.target.instance in self.system.connectors:
                yield Action(wire.target.name, value=carried)
            else:
                yield from self._set(wire.target.name, wire.target.variable, carried)

    def _channel_actions(self, targets: Iterable[str], columns: Mapping[int, float]) -> Iterator[Action]:
        for target in (element for named in targets for element in self._elements(named)):
            reached = self._reached(target)
            if reached in self.connected:
                yield Action(reached, columns)
            elif not self.system.unread:  # a connection of an FMU that could not be read may be missing
                listed = ", ".join(self.connected[:_MOST_LISTED]) or "none"
                listed += ", ..." if len(self.connected) > _MOST_LISTED else ""
                self._add("not a connected input", where=target, expected=f"one of {listed}")
