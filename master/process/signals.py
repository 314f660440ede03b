"""SIGINT (Ctrl-C), SIGTERM and SIGHUP: at once where nothing is to be saved, noted where something is."""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

from . import position

SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]

_SAME_SECONDS = 0.3  # a terminal and a parent process may both send what the user meant once


def exit_status(number: int) -> int:
    """Return the exit status of a command that a signal ended."""
    return 128 + number


def end_at_once() -> None:
    """Let each of the signals end this process through its clean-up, with status 128 + its number."""
    for number in SIGNALS:
        signal.signal(number, _leave)


def ignore() -> None:
    """Let nothing interrupt what this process does last."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def end_as_the_system_does() -> None:
    """Let a signal end this process where no Python runs any more."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)


def exit_if_unheeded() -> None:
    """End this process if a signal came."""
    if _unheeded:
        sys.exit(exit_status(_unheeded[0]))


@contextmanager
def held() -> Iterator[None]:
    """Hold signals back until the block ends; for good in processes that are started within."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _leave(number: int, _: FrameType | None) -> None:
    """Exit; a signal that follows at once is the same one, and does not disturb the clean-up of the first."""
    global _left
    now = time.monotonic()
    if _unheeded and now - _left < _SAME_SECONDS:
        return
    _left = now
    _unheeded.append(number)
    sys.unraisablehook = _quiet
    sys.exit(exit_status(_unheeded[0]))


def _quiet(fault: sys.UnraisableHookArgs) -> None:
    """Show no traceback where the exit that a signal asks for came amid a destructor or a callback."""
    if not isinstance(fault.exc_value, SystemExit):
        sys.__unraisablehook__(fault)


_left = 0.0
_unheeded: list[int] = []
"""Signals whose exit some library may have caught; see `noted` and `exit_if_unheeded`."""


class Interruption:
    """Signals noted so far: the first one, and whether the user insists."""

    def __init__(self) -> None:
        self.number: int | None = None
        self.since = 0.0
        self.insists = False

    def __bool__(self) -> bool:
        return self.number is not None

    def note(self, number: int, _: FrameType | None = None) -> None:
        """Take a signal; one that follows at once is the same one."""
        now = time.monotonic()
        position.current().cells[position.STOP] = 1.0
        if self.number is None:
            self.number = number
            self.since = now
        elif now - self.since > _SAME_SECONDS:
            self.insists = True

    def waited(self) -> float:
        """Return the time since the first signal [s], 0 without one."""
        return 0.0 if self.number is None else time.monotonic() - self.since


_active: list[Interruption] = []


@contextmanager
def noted(numbers: Sequence[int] = SIGNALS) -> Iterator[Interruption]:
    """
    Note signals instead of acting on them, and ask the run in this process to stop.

    Within another block of this kind that block goes on noting; outside the main thread nothing is changed.
    """
    if _active:
        yield _active[-1]
        return
    interruption = Interruption()
    if threading.current_thread() is not threading.main_thread():
        yield interruption
        return
    before = {number: signal.signal(number, interruption.note) for number in numbers}
    _active.append(interruption)
    for number in _unheeded:
        interruption.note(number)
    try:
        yield interruption
    finally:
        _active.pop()
        position.current().cells[position.STOP] = 0.0
        for number, handler in before.items():
            signal.signal(number, handler)


def remind() -> None:
    """Ask a run that begins to stop, if a signal has been noted before it."""
    if _active and _active[-1]:
        position.current().cells[position.STOP] = 1.0


def hand_on(interruption: Interruption) -> None:
    """Let a signal that a run noted end the command, where that works with runs and saves none."""
    if interruption.number is not None and signal.getsignal(interruption.number) is _leave:
        _leave(interruption.number, None)


def forget() -> None:
    """In a forked process: what the parent notes is the parent's matter."""
    _active.clear()
    for number in SIGNALS:
        signal.signal(number, _pass)


def _pass(number: int, _: FrameType | None) -> None:
    """Let the parent process decide."""
