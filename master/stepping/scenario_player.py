"""A scenario carried out in a run: when to stop next, which channels and values to change, and back again."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from master.fmi.slave import Slave
from master.stepping.machine.program import Floats, Integers, Program
from master.stepping.outcome import Happened
from master.system.channel import DELAY, DRAWN, FALLBACK, JITTER, MODE, OFFSET, PASS, RANDOM
from master.system.graph import System
from master.system.grid import Grid
from master.system.scenario import Action, Condition, Scenario, ScenarioEvent
from master.text.signal_name import SignalName

NEVER = 2**62  # no run has as many ticks
_NEUTRAL = {MODE: float(PASS), OFFSET: 0.0, DELAY: 0.0, JITTER: 0.0}


@dataclass(frozen=True)
class PlayerState:
    """Events that wait and act, conditions that have not come true, values from before the first event."""

    waiting: tuple[tuple[int, ScenarioEvent], ...]
    armed: tuple[bool, ...]
    acting: tuple[tuple[int, Action], ...]
    before: Mapping[str, float]
    happened: tuple[Happened, ...] = ()


class ScenarioPlayer:
    """
    Changes channels and values when a scenario's time has come; times are counted in ticks.

    Of events that overlap on the same thing, the one that began last holds; when it ends, the one before
    it holds again, and in the end the value from before the first. `stopped` is the condition that has ended
    the run.
    """

    def __init__(
        self,
        scenario: Scenario,
        system: System,
        program: Program,
        slaves: Mapping[str, Slave],
        grid: Grid,
    ) -> None:
        self._scenario = scenario
        self._system = system
        self._program = program
        self._slaves = slaves
        self._grid = grid
        self._waiting = [(grid.tick_at(e.at), e) for e in scenario.events if e.at is not None]
        self._conditional = [e for e in scenario.events if e.condition is not None]
        self._conditions = [e.condition for e in self._conditional if e.condition] + list(scenario.stops)
        self._places = [program.place[condition.signal] for condition in self._conditions]
        self._armed = [True] * len(self._conditions)
        self.stopped: Condition | None = None
        self._acting: list[tuple[int, Action]] = []
        self._before: dict[str, float] = {}
        self._happened: list[Happened] = []
        for name, row in program.channel_of.items():
            start = system.instances[SignalName(name).instance].value_of(SignalName(name).variable)
            program.memory.channels[row, FALLBACK] = float(start or 0.0)
            program.memory.channels[row, RANDOM] = 1.0
            program.memory.channels[row, DRAWN] = -1.0

    def triggers(self) -> tuple[Integers, Floats]:
        """Arrays `triggers` and `thresholds` of `LimitMonitor`."""
        places = [[place, armed] for place, armed in zip(self._places, self._armed, strict=True)]
        thresholds = [[c.sign, c.threshold] for c in self._conditions]
        return np.array(places, dtype=np.int64).reshape(-1, 2), np.array(
            thresholds, dtype=np.float64
        ).reshape(-1, 2)

    def conditions(self) -> list[str]:
        """Signals that conditions look at."""
        return [condition.signal for condition in self._conditions]

    def next_tick(self) -> int:
        """First tick before which something is to be changed."""
        ticks = [tick for tick, _ in self._waiting] + [end for end, _ in self._acting]
        return min(ticks, default=NEVER)

    def not_reached(self) -> list[str]:
        """Conditions that did not come true."""
        n_events = len(self._conditional)
        pairs = zip(self._conditions[:n_events], self._armed[:n_events], strict=True)
        return [str(condition) for condition, armed in pairs if armed]

    def happened(self) -> list[Happened]:
        """Conditions that came true, in the order of time."""
        return list(self._happened)

    def look(self, triggers: Integers, tick: int) -> None:
        """Carry out every event whose condition is true before a tick, each once; note what ends the run."""
        for i, condition in enumerate(self._conditions):
            if not (self._armed[i] and condition.holds(self._program.values[self._places[i]])):
                continue
            self._armed[i] = False
            triggers[i, 1] = 0
            self._happened.append(Happened(str(condition), self._grid.time(tick)))
            if i < len(self._conditional):
                self._begin(self._conditional[i], tick)
            else:
                self.stopped = self.stopped or condition

    def advance(self, tick: int) -> None:
        """Carry out all that is due before a tick, endings first."""
        over = [action for end, action in self._acting if end <= tick]
        self._acting = [(end, action) for end, action in self._acting if end > tick]
        self._refresh(over)
        due = [event for at, event in self._waiting if at <= tick]
        self._waiting = [(at, event) for at, event in self._waiting if at > tick]
        for event in due:
            self._begin(event, tick)

    def state(self) -> PlayerState:
        """Return what has been played so far."""
        return PlayerState(
            waiting=tuple(self._waiting),
            armed=tuple(self._armed),
            acting=tuple(self._acting),
            before=dict(self._before),
            happened=tuple(self._happened),
        )

    def restore(self, state: PlayerState) -> None:
        """Go back to where it was."""
        self._waiting = list(state.waiting)
        self._armed = list(state.armed)
        self._acting = list(state.acting)
        self._before = dict(state.before)
        self.stopped = None
        self._happened = list(state.happened)

    def as_json(self) -> dict[str, Any]:
        """Return what has been played so far, for `restore_json` in another process."""
        events = self._scenario.events
        return {
            "waiting": [[tick, events.index(event)] for tick, event in self._waiting],
            "armed": list(self._armed),
            "acting": [[end, a.target, list(a.columns.items()), a.value] for end, a in self._acting],
            "before": dict(self._before),
            "happened": [[one.condition, one.t] for one in self._happened],
        }

    def restore_json(self, state: Mapping[str, Any]) -> None:
        """Go back to where it was in another process, with the same scenario."""
        acting = [
            (end, Action(target, {int(c): number for c, number in columns}, value))
            for end, target, columns, value in state["acting"]
        ]
        waiting = tuple((tick, self._scenario.events[i]) for tick, i in state["waiting"])
        happened = tuple(Happened(condition, t) for condition, t in state["happened"])
        self.restore(PlayerState(waiting, tuple(state["armed"]), tuple(acting), state["before"], happened))

    def _begin(self, event: ScenarioEvent, tick: int) -> None:
        end = NEVER if event.duration is None else tick + self._grid.ticks_of(event.duration)
        setting = [action.target for action in event.actions if action.value is not None]
        self._remember([target for target in setting if target not in self._before])
        for action in event.actions:
            if RANDOM in action.columns:
                row = self._program.channel_of[action.target]
                self._program.memory.channels[row, RANDOM] = action.columns[RANDOM]
            self._acting.append((end, action))
        self._refresh(event.actions)

    def _remember(self, targets: Sequence[str]) -> None:
        """Read values before they are set."""
        for instance, own in self._by_instance(targets).items():
            if instance in self._system.connectors:
                place = self._program.place
                self._before |= {target: float(self._program.values[place[target]]) for target in own}
                continue
            slave = self._slaves[instance]
            found = slave.get([self._system.port(target).variable for target in own])
            self._before |= zip(own, found, strict=True)

    def _refresh(self, actions: Iterable[Action]) -> None:
        """Let the targets of actions have what all acting events make of them, in the order of beginning."""
        acting: dict[str, list[Action]] = {action.target: [] for action in actions}
        for _, action in self._acting:
            if action.target in acting:
                acting[action.target].append(action)
        values: dict[str, float] = {}
        for target, own in acting.items():
            row = self._program.channel_of.get(target)
            if row is None:
                given = [action.value for action in own if action.value is not None]
                values[target] = given[-1] if given else self._before[target]
                continue
            columns = dict(_NEUTRAL)
            for action in own:
                columns |= {c: number for c, number in action.columns.items() if c != RANDOM}
            for column, number in columns.items():
                self._program.memory.channels[row, column] = number
        self._set(values)

    def _set(self, values: Mapping[str, float]) -> None:
        """Set values, those of an instance at once, and where each step sets them too, what it sets."""
        for instance, own in self._by_instance(values).items():
            if instance in self._system.connectors:
                continue
            variables = [self._system.port(target).variable for target in own]
            self._slaves[instance].set(variables, [values[target] for target in own])
        for target, value in values.items():
            if target in self._program.place:  # an element of an array that is set as a whole each step
                self._program.values[self._program.place[target]] = value

    def _by_instance(self, targets: Iterable[str]) -> dict[str, list[str]]:
        found: dict[str, list[str]] = {}
        for target in targets:
            found.setdefault(SignalName(target).instance, []).append(target)
        return found
