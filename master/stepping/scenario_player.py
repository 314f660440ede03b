"""A scenario carried out in a run: when to stop next, which channels and values to change, and back again."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from master.fmi.description import Variable
from master.fmi.slave import Slave
from master.stepping.machine.program import Floats, Integers, Program
from master.system.channel import DELAY, DRAWN, FALLBACK, JITTER, MODE, OFFSET, PASS, RANDOM
from master.system.graph import System
from master.system.scenario import Action, Scenario, ScenarioEvent

_NEUTRAL = {MODE: float(PASS), OFFSET: 0.0, DELAY: 0.0, JITTER: 0.0}


class Director:
    """
    Changes channels and values when a scenario's time has come.

    Of events that overlap on the same thing, the one that began last holds; when it ends, the one before
    it holds again, and in the end the value from before the first.
    """

    def __init__(
        self, scenario: Scenario, system: System, program: Program, slaves: Mapping[str, Slave]
    ) -> None:
        self._system, self._program, self._slaves = system, program, slaves
        self._waiting = [e for e in scenario.events if e.condition is None]
        self._conditional = [e for e in scenario.events if e.condition is not None]
        self._places = [program.place[e.condition.signal] for e in self._conditional if e.condition]
        self._armed = [True] * len(self._conditional)
        self._acting: list[tuple[float, Action]] = []
        self._before: dict[str, float] = {}
        for name, row in program.channel_of.items():
            start = system.instances[name.partition(".")[0]].value_of(name.partition(".")[2])
            program.memory.channels[row, FALLBACK] = float(start or 0.0)
            program.memory.channels[row, RANDOM] = 1.0
            program.memory.channels[row, DRAWN] = -1.0

    def triggers(self) -> tuple[Integers, Floats]:
        """Arrays `triggers` and `thresholds` of `loop.Watch`."""
        conditions = [e.condition for e in self._conditional if e.condition is not None]
        places = [[place, armed] for place, armed in zip(self._places, self._armed, strict=True)]
        thresholds = [[c.sign, c.threshold] for c in conditions]
        return np.array(places, dtype=np.int64).reshape(-1, 2), np.array(
            thresholds, dtype=np.float64
        ).reshape(-1, 2)

    def next_time(self) -> float:
        """Earliest time [s] at which something is to be changed."""
        times = [e.at for e in self._waiting if e.at is not None] + [end for end, _ in self._acting]
        return min(times, default=np.inf)

    def not_reached(self) -> list[str]:
        """Conditions that did not come true."""
        pairs = zip(self._conditional, self._armed, strict=True)
        return [str(e.condition) for e, armed in pairs if armed]

    def look(self, triggers: Integers, now: float) -> None:
        """Carry out every event whose condition is true at `now` [s], each once."""
        for i, event in enumerate(self._conditional):
            value = self._program.values[self._places[i]]
            if self._armed[i] and event.condition is not None and event.condition.holds(value):
                self._armed[i] = False
                triggers[i, 1] = 0
                self._begin(event, now)

    def advance(self, now: float, tolerance: float) -> None:
        """Carry out all that is due at `now` [s] within a tolerance [s], endings first."""
        by = now + tolerance
        over = [(end, action) for end, action in self._acting if end <= by]
        self._acting = [(end, action) for end, action in self._acting if end > by]
        for target in dict.fromkeys(action.target for _, action in over):
            self._refresh(target)
        due = [e for e in self._waiting if e.at is not None and e.at <= by]
        self._waiting = [e for e in self._waiting if e not in due]
        for event in due:
            self._begin(event, now)

    def _begin(self, event: ScenarioEvent, now: float) -> None:
        end = np.inf if event.duration is None else now + event.duration
        for action in event.actions:
            if action.value is not None and action.target not in self._before:
                slave, variable = self._slave_and_variable(action.target)
                [self._before[action.target]] = slave.get([variable])
            if RANDOM in action.columns:
                row = self._program.channel_of[action.target]
                self._program.memory.channels[row, RANDOM] = action.columns[RANDOM]
            self._acting.append((end, action))
            self._refresh(action.target)

    def _refresh(self, target: str) -> None:
        """Let a target have what its acting events make of it, in the order of their beginning."""
        acting = [action for _, action in self._acting if action.target == target]
        row = self._program.channel_of.get(target)
        if row is None:
            values = [action.value for action in acting if action.value is not None]
            self._set(target, values[-1] if values else self._before[target])
            return
        columns = dict(_NEUTRAL)
        for action in acting:
            columns |= {c: number for c, number in action.columns.items() if c != RANDOM}
        for column, number in columns.items():
            self._program.memory.channels[row, column] = number

    def _set(self, target: str, value: float) -> None:
        slave, variable = self._slave_and_variable(target)
        slave.set([variable], [value])
        if target in self._program.place:  # an element of an array that is set as a whole each step
            self._program.values[self._program.place[target]] = value

    def _slave_and_variable(self, target: str) -> tuple[Slave, Variable]:
        port = self._system.port(target)
        return self._slaves[port.instance], port.variable
