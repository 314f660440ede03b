"""
A scenario: what happens to values and connections during a run, at a time or when a condition comes true.

A fault of the measuring chain acts on a connected input through its channel: `freeze` holds the last
value, `drop` gives the FMU's own start value, `offset` adds, `delay` and `jitter` age the value by
whole ticks. `set` changes a tunable parameter or an input that is not connected.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..errors import ConfigError
from ..fmi.description import Description, Variable
from ..fmi.slave import Slave
from ..system.config import Event, LoadedConfig
from ..system.graph import System, signal_fault
from ..system.values import parse
from .program import (
    DELAY,
    DROP,
    FALLBACK,
    FREEZE,
    JITTER,
    MODE,
    OFFSET,
    PASS,
    RANDOM,
    Floats,
    Integers,
    Program,
)

_CONDITION = re.compile(r"\s*(?P<signal>[^\s<>]+)\s*(?P<sense>[<>])\s*(?P<threshold>\S+)\s*")


@dataclass(frozen=True)
class Condition:
    """`signal > threshold` or `signal < threshold` (sign -1)."""

    signal: str
    sign: float
    threshold: float


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
    """All events of a run."""

    events: tuple[ScenarioEvent, ...] = ()

    def channels(self) -> dict[str, int]:
        """Connected inputs that events act on, with the most ticks that their values may age."""
        longest: dict[str, int] = {}
        for action in (a for e in self.events for a in e.actions if a.value is None):
            age = int(action.columns.get(DELAY, 0.0) + action.columns.get(JITTER, 0.0))
            longest[action.target] = max(longest.get(action.target, 0), age)
        return longest


def make_scenario(loaded: LoadedConfig, system: System) -> Scenario:
    """
    Check the events of a configuration against its system.

    Raises:
        ConfigError: With every fault.
    """
    problems: list[str] = []
    events = []
    for i, event in enumerate(loaded.config.events):
        where = loaded.where("events", i)
        try:
            events.append(_event(event, system))
        except ConfigError as error:
            problems += [f"{where}: {problem}" for problem in error.problems]
    if problems:
        raise ConfigError(problems)
    return Scenario(tuple(events))


def _event(event: Event, system: System) -> ScenarioEvent:
    condition = None if event.when is None else _condition(event.when, system)
    actions = [
        *_set_actions(event, system),
        *_channel_actions(event.freeze, {MODE: FREEZE}, system),
        *_channel_actions(event.drop, {MODE: DROP}, system),
    ]
    for column, amounts in ((OFFSET, event.offset), (DELAY, event.delay), (JITTER, event.jitter)):
        for target, amount in amounts.items():
            seed = {RANDOM: float(event.seed)} if column == JITTER else {}
            actions += _channel_actions([target], {column: float(amount), **seed}, system)
    return ScenarioEvent(tuple(actions), event.at, condition, event.duration)


def _descriptions(system: System) -> dict[str, Description]:
    return {name: i.description for name, i in system.instances.items()}


def _condition(text: str, system: System) -> Condition:
    match = _CONDITION.fullmatch(text)
    if match is None:
        raise ConfigError([f"when: not a condition, got {text!r}, expected 'instance.variable > number'"])
    fault = signal_fault(_descriptions(system), match["signal"], ("output",))
    if fault is not None:
        raise ConfigError([f"when: {fault}"])
    try:
        threshold = float(match["threshold"])
    except ValueError:
        raise ConfigError([f"when: not a number, got {match['threshold']!r}, expected a threshold"]) from None
    return Condition(match["signal"], 1.0 if match["sense"] == ">" else -1.0, threshold)


def _set_actions(event: Event, system: System) -> Iterator[Action]:
    connected = {w.target.name for w in system.wires}
    for target, value in event.set.items():
        fault = signal_fault(_descriptions(system), target, ("parameter", "input"))
        if fault is not None:
            raise ConfigError([f"set: {fault}"])
        variable = system.port(target).variable
        if target in connected:
            raise ConfigError([f"set: {target} is connected, expected offset, freeze or drop for it"])
        if variable.causality == "parameter" and variable.variability != "tunable":
            raise ConfigError([f"set: {target} is fixed during a run, expected a tunable parameter"])
        try:
            yield Action(target, value=float(parse(variable, value)))
        except ValueError as error:
            raise ConfigError([f"set: {target}: value not allowed, got {value!r}, {error}"]) from None


def _channel_actions(
    targets: Sequence[str], columns: Mapping[int, float], system: System
) -> Iterator[Action]:
    connected = [w.target.name for w in system.wires]
    for target in targets:
        if target not in connected:
            listed = ", ".join(connected)
            raise ConfigError([f"{target}: not a connected input, expected one of {listed}"])
        yield Action(target, columns)


class Director:
    """Carries a scenario out in a run: says when to stop next, and changes channels and values."""

    def __init__(
        self, scenario: Scenario, system: System, program: Program, slaves: Mapping[str, Slave]
    ) -> None:
        self._system, self._program, self._slaves = system, program, slaves
        self._waiting = [e for e in scenario.events if e.condition is None]
        self._conditional = [e for e in scenario.events if e.condition is not None]
        self._endings: list[tuple[float, Action, dict[int, float]]] = []
        for name, row in program.channel_of.items():
            start = system.instances[name.partition(".")[0]].value_of(name.partition(".")[2])
            program.memory.channels[row, FALLBACK] = float(start or 0.0)
            program.memory.channels[row, RANDOM] = 1.0

    def triggers(self) -> tuple[Integers, Floats]:
        """Arrays `triggers` and `thresholds` of `loop.Watch`."""
        conditions = [e.condition for e in self._conditional if e.condition is not None]
        places = [[self._program.place[c.signal], 1] for c in conditions]
        thresholds = [[c.sign, c.threshold] for c in conditions]
        return np.array(places, dtype=np.int64).reshape(-1, 2), np.array(
            thresholds, dtype=np.float64
        ).reshape(-1, 2)

    def next_time(self) -> float:
        """Earliest time [s] at which something is to be changed."""
        times = [e.at for e in self._waiting if e.at is not None] + [time for time, _, _ in self._endings]
        return min(times, default=np.inf)

    def fire(self, trigger: int, now: float) -> None:
        """Carry out the event of a trigger."""
        self._carry_out(self._conditional[trigger], now)

    def advance(self, now: float) -> None:
        """Carry out all that is due at `now` [s], endings first."""
        over = [ending for ending in self._endings if ending[0] <= now]
        self._endings = [ending for ending in self._endings if ending[0] > now]
        for _, action, before in over:
            self._apply(action, before)
        due = [e for e in self._waiting if e.at is not None and e.at <= now]
        self._waiting = [e for e in self._waiting if e not in due]
        for event in due:
            self._carry_out(event, now)

    def _carry_out(self, event: ScenarioEvent, now: float) -> None:
        for action in event.actions:
            before = self._before(action)
            self._apply(action, dict(action.columns) if action.value is None else {0: action.value})
            if event.duration is not None:
                self._endings.append((now + event.duration, action, before))

    def _before(self, action: Action) -> dict[int, float]:
        if action.value is None:
            return {
                column: float(PASS) if column == MODE else 0.0
                for column in action.columns
                if column != RANDOM
            }
        slave, variable = self._slave_and_variable(action.target)
        return {0: slave.get([variable])[0]}

    def _apply(self, action: Action, numbers: Mapping[int, float]) -> None:
        if action.value is None:
            row = self._program.memory.channels[self._program.channel_of[action.target]]
            for column, number in numbers.items():
                row[column] = number
            return
        slave, variable = self._slave_and_variable(action.target)
        slave.set([variable], [numbers[0]])

    def _slave_and_variable(self, target: str) -> tuple[Slave, Variable]:
        port = self._system.port(target)
        return self._slaves[port.instance], port.variable
