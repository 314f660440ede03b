"""
Processes that make runs, watched from here: whatever a run does to its process, the others go on.

A process is forked from this one, and gets the numbers of a few runs at a time. It ends when an FMU crashes
or is stuck; then its present run has a row that says so, and a new process goes on with the rest. A
process that was killed from outside is no fault of a run: the run is made again.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection, Pipe, wait
from typing import Any

from master.errors import ConfigError, Problem
from master.fuse.runs import FusedForm
from master.process import child, signals
from master.process.child import Child
from master.stepping.machine.compiled import load_plain

from .fused import Fusing
from .plan import Plan
from .stepper import CRASHED, TIMED_OUT, Row, Stepper

_AHEAD_SECONDS = 0.2  # work that a process has before it, so that it never waits
_MOST_AHEAD = 256
_LOOK_SECONDS = 0.1
_MOST_ATTEMPTS = 10
_FROM_OUTSIDE = (signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT)
_FULL = 100  # runs after which a process's pace is known well


@dataclass(frozen=True)
class Order:
    """
    A run to be made: its number in the sample, and values over those of the sample.

    `is_apart`: the fused form has shown other bits, and is not to be used.
    """

    run: int
    more: Mapping[str, Any] | None = None
    attempt: int = 1
    is_apart: bool = False


@dataclass
class _Hand:
    """
    A process, what it was given to do, and since when it has been at the first of that.

    `form` is what it was told last of the fused form.
    """

    child: Child
    pipe: Connection
    orders: deque[Order] = field(default_factory=deque)
    since: float = 0.0
    leaves: bool = False
    form: FusedForm | str | None = None


def require_fork(where: str) -> None:
    """
    See that this system can fork processes.

    Args:
        where: What needs them.

    Raises:
        ConfigError: If it cannot.
    """
    if not child.IS_POSSIBLE:
        expected = "Linux, or --scheduler for a campaign without tune"
        raise ConfigError(
            [Problem("makes its runs in forked processes", where=where, got=sys.platform, expected=expected)]
        )


class Crew:
    """
    Some processes that make the runs of a plan.

    `restarts` counts the processes that were replaced.
    """

    def __init__(self, plan: Plan, n: int) -> None:
        self.plan = plan
        self.n = n
        self.restarts = 0
        self._hands: list[_Hand] = []
        self._seconds = 0.0
        self._done = 0
        self._again: deque[Order] = deque()
        self._fusing = Fusing(plan)
        self._late: deque[Order] = deque()  # killed ones are made last: kills may come in a burst
        load_plain()  # once, for all processes

    def rows(
        self, orders: Iterator[Order], is_over: Callable[[], bool], *, keep: bool = False
    ) -> Iterator[Row | None]:
        """
        Make runs; rows come as they are done, in any order.

        Args:
            orders: What is to be made; taken from as processes have room.
            is_over: Asked now and then; True ends all at once, runs that are going on have no rows then.
            keep: Whether the processes stay for more runs.

        Yields:
            Rows, and None now and then while there is none.
        """
        try:
            while True:
                more = self._hand_out(orders)
                if not more and not any(hand.orders for hand in self._hands):
                    return
                self._fusing.advance()
                yield from self._collected()
                yield None
                if is_over():
                    return
        finally:
            if not keep:
                self.close()

    def close(self) -> None:
        """End all processes at once."""
        for hand in self._hands:
            hand.child.close()
            hand.pipe.close()
        self._hands.clear()
        self._fusing.close()

    def _hand_out(self, orders: Iterator[Order]) -> bool:
        """Let each process have some runs before it; False where no more are to be had."""
        more = True
        for hand in self._hands:
            while more and not hand.leaves and len(hand.orders) < self._ahead():
                more = self._give(hand, orders)
        while more and len(self._hands) < self.n:
            order = self._next(orders)
            if order is None:
                return False
            hand = self._hire()
            self._send(hand, order)
        return more

    def _give(self, hand: _Hand, orders: Iterator[Order]) -> bool:
        order = self._next(orders)
        if order is not None:
            self._send(hand, order)
        return order is not None

    def _next(self, orders: Iterator[Order]) -> Order | None:
        order = self._again.popleft() if self._again else next(orders, None)
        return self._late.popleft() if order is None and self._late else order

    def _send(self, hand: _Hand, order: Order) -> None:
        if not hand.orders:
            hand.since = time.monotonic()
        hand.orders.append(order)
        news = None if hand.form is self._fusing.form else self._fusing.form
        hand.form = self._fusing.form
        with suppress(OSError):  # it has just ended: its pipe says so
            hand.pipe.send((order, news))

    def _ahead(self) -> int:
        if self._done == 0:
            return 1
        return max(2, min(_MOST_AHEAD, int(_AHEAD_SECONDS * self._done / max(self._seconds, 1e-9))))

    def _hire(self) -> _Hand:
        here, there = Pipe()
        worker = Child()
        with signals.held():  # what a terminal sends to all is this process's matter
            worker.begin(lambda: _work(self.plan, here, there))
        there.close()
        hand = _Hand(worker, here)
        self._hands.append(hand)
        return hand

    def _collected(self) -> Iterator[Row]:
        """Take the rows that are there, and see after processes that have ended or are stuck."""
        pipes: dict[Any, _Hand] = {hand.pipe: hand for hand in self._hands}
        for pipe in wait(list(pipes), _LOOK_SECONDS):
            yield from self._taken(pipes[pipe])
        now = time.monotonic()
        for hand in list(self._hands):
            if hand.orders and now - hand.since > self.plan.campaign.time_limit:
                yield self._stuck(hand)

    def _taken(self, hand: _Hand) -> Iterator[Row]:
        try:
            while hand.pipe.poll():
                row, leaves = hand.pipe.recv()
                hand.orders.popleft()
                hand.since = time.monotonic()
                hand.leaves = leaves
                self._pace(row.wall)
                yield row
        except (EOFError, OSError):
            yield from self._ended(hand)

    def _pace(self, seconds: float) -> None:
        """Keep the mean time of the last runs."""
        if self._done >= _FULL:
            self._seconds *= 1.0 - 1.0 / _FULL
            self._done -= 1
        self._seconds += seconds
        self._done += 1

    def _ended(self, hand: _Hand) -> Iterator[Row]:
        """Dismiss a process that has ended; a row if that is the fault of a run."""
        while not hand.child.has_ended():
            pass
        orders = hand.orders
        if orders and not hand.leaves:
            first = orders.popleft()
            if self._was_killed(hand) and first.attempt < _MOST_ATTEMPTS:
                self._late.append(replace(first, attempt=first.attempt + 1))
            else:
                call = hand.child.position.call()
                t = None if call is None else hand.child.position.time()
                where = "" if call is None else f"{call.instance}{'' if t is None else f' at t={t:.15g} s'}: "
                yield self._row(first, CRASHED, where + hand.child.ending(), time.monotonic() - hand.since)
        self._dismiss(hand)

    def _was_killed(self, hand: _Hand) -> bool:
        """Whether a process was ended by a signal that no FMU raises by a fault of its own."""
        number = hand.child.ended_by()
        return number in _FROM_OUTSIDE

    def _stuck(self, hand: _Hand) -> Row:
        order = hand.orders.popleft()
        call = hand.child.position.call()
        where = f" in {call.instance}, {call.function}" if call else ""
        text = f"took more than the time limit of {self.plan.campaign.time_limit:g} s{where}"
        row = self._row(order, TIMED_OUT, text, time.monotonic() - hand.since)
        self._dismiss(hand)
        return row

    def _row(self, order: Order, status: str, message: str, seconds: float) -> Row:
        values = {**self.plan.values(order.run), **(order.more or {})}
        return Row(order.run, status, message, seconds, values=values)

    def _dismiss(self, hand: _Hand) -> None:
        self.restarts += 1
        self._again.extendleft(reversed(hand.orders))
        self._hands.remove(hand)
        hand.child.close()
        hand.pipe.close()


def _work(plan: Plan, here: Connection, there: Connection) -> None:
    """In a process of the crew: make the runs whose numbers come, until no more come."""
    here.close()
    signals.forget()
    stepper = Stepper(plan)
    try:
        while True:
            order, form = there.recv()
            if form is not None:
                stepper.proven.form = form
            row = stepper.row(order.run, order.more, is_apart=order.is_apart)
            there.send((row, stepper.is_spent))
            if stepper.is_spent:
                os._exit(0)
    except (EOFError, OSError):
        return
