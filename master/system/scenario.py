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

from master.errors import ConfigError
from master.fmi.description import Description, Kind
from master.fmi.values import parse

from .channel import DELAY, DROP, FREEZE, JITTER, MODE, OFFSET, RANDOM
from .config import Event, LoadedConfig, finite
from .graph import System, signal_fault

_DEEDS = ("set", "offset", "freeze", "drop", "delay", "jitter")
_CONDITION = re.compile(r"\s*(?P<signal>[^\s<>]+)\s*(?P<sense>[<>])\s*(?P<threshold>\S+)\s*")


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
    config = loaded.config
    for i, event in enumerate(config.events):
        where = loaded.where("events", i)
        if event.at is not None and not config.start_time <= event.at < config.stop_time:
            problems.append(
                f"{where}: not within the run, got at {event.at:g} s, "
                f"expected from {config.start_time:g} s to before {config.stop_time:g} s"
            )
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
    if not actions:
        raise ConfigError([f"does nothing, expected one of {', '.join(_DEEDS)}"])
    _refuse_offsets_of_truths(event, system)
    return ScenarioEvent(tuple(actions), event.at, condition, event.duration)


def _refuse_offsets_of_truths(event: Event, system: System) -> None:
    """An offset of a Boolean means nothing, a part of one on a whole number would be rounded away."""
    for target, amount in event.offset.items():
        kind = system.port(target).variable.kind
        if kind is Kind.BOOLEAN:
            raise ConfigError(
                [f"offset: {target} is a Boolean, expected freeze, drop, delay or jitter for it"]
            )
        if kind is Kind.INTEGER and not amount.is_integer():
            raise ConfigError([f"offset: {target} is an integer, got {amount:g}, expected a whole number"])


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
        threshold = finite(float(match["threshold"]))
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
        if variable.kind is Kind.STRING:
            raise ConfigError([f"set: {target} is a string, expected a number or a Boolean during a run"])
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
