"""
What FMUs say through their loggers: the messages of the present call, counts of all, and a log file.

The memory that this needs does not grow with the number of messages.
"""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO, Any

from master.process import position
from master.process.position import Call
from master.text.printable import printable

from .status import Status, status_name

LEVELS = {"error": Status.DISCARD, "warning": Status.WARNING, "all": Status.OK}

CHANGES_FLOAT_MODE = "changes rounding, traps or flush to zero, which is undone after its call"

AT_THE_END = "at the end"  # category of what spoils no results any more

_MOST_OF_A_CALL = 5
_MOST_DIFFERENT = 20  # of an instance; numbers in a text make each message a different one
_MOST_BYTES = 50_000_000  # of a log file
_OTHERS = "(other texts)"
_PYTHON_NOTE = re.compile("py exception")  # PythonFMU's note on an exception that it reports too

TimeOf = Callable[[int], float]


@dataclass
class Said:
    """Messages of one FMU that are alike: the first one came at time t [s], or before the first step."""

    fmu: str
    status: str
    category: str
    text: str
    t: float | None
    count: int = 1


@dataclass(frozen=True)
class _Message:
    status: int
    category: str
    text: str

    def __str__(self) -> str:
        return f"[{self.category}] {self.text}" if self.category else self.text


class _OfCall:
    """The worst messages of an FMU in one call."""

    def __init__(self, call: Call | None) -> None:
        self.call = call
        self._messages: list[_Message] = []
        self._least = 0
        self._left_out = 0

    def keep(self, message: _Message) -> None:
        """Take a message; of too many the last one among the least bad is dropped."""
        severity = _severity(message.status)
        if len(self._messages) == _MOST_OF_A_CALL:
            self._left_out += 1
            if severity <= self._least:
                return
            least = max(i for i, m in enumerate(self._messages) if _severity(m.status) == self._least)
            del self._messages[least]
        self._messages.append(message)
        self._least = min(_severity(m.status) for m in self._messages)

    def belongs_to(self, call: Call | None) -> bool:
        """Whether they are of this call, or of the same turn of the FMU in the stepping loop."""
        if self.call is None or call is None:
            return self.call is call
        same_turn = self.call.is_in_loop and call.is_in_loop and self.call.tick == call.tick
        return same_turn or self.call == call

    def text(self) -> str:
        """Return the messages, the worst first; those without a fault only where there is no other."""
        relevant = [m for m in self._messages if m.status != Status.OK] or self._messages
        relevant = [m for m in relevant if not _PYTHON_NOTE.search(m.text)] or relevant
        worst_first = sorted(relevant, key=lambda m: -_severity(m.status))
        more = [f"... and {self._left_out} more"] if self._left_out else []
        return "; ".join([*map(str, worst_first), *more])


class MessageLog:
    """
    Messages of all FMUs of a run.

    Args:
        time_of: Time [s] of a tick.
        file: Where each message is written.
        changed: Called with the FMU when a message came that is not like an earlier one.
    """

    def __init__(
        self,
        time_of: TimeOf | None = None,
        file: LogFile | None = None,
        changed: Callable[[MessageLog, str], None] | None = None,
    ) -> None:
        self._time_of = time_of
        self._file = file
        self._changed = changed
        self._said: dict[tuple[str, int, str, str], Said] = {}
        self._of_call: dict[str, _OfCall] = {}
        self._sources: list[Callable[[], None]] = []

    def add_source(self, collect: Callable[[], None]) -> None:
        """Let `collect` bring messages from where they wait, whenever this log is asked for them."""
        self._sources.append(collect)

    def collect(self) -> None:
        """Take the messages that wait somewhere else."""
        for source in self._sources:
            source()

    def note(self, fmu: str, status: int, category: str, text: str) -> None:
        """Take a message of the present call."""
        self.take(fmu, status, category, text, position.current().call())

    def take(self, fmu: str, status: int, category: str, text: str, call: Call | None) -> None:
        """Take a message that came in a call."""
        message = _Message(status, printable(category.strip()), printable(text.strip()))
        told = self._of_call.get(fmu)
        if told is None or told.call != call:
            told = self._of_call[fmu] = _OfCall(call)
        told.keep(message)
        t = None if call is None or self._time_of is None else self._time_of(call.tick)
        if self._file is not None:
            self._file.write(fmu, status, str(message), t)
        if status != Status.OK:
            self._count(fmu, message, t)

    def of_call(self, fmu: str) -> str:
        """Return what an FMU said in the present call (or turn), the worst first; empty if nothing."""
        return self.text_of(fmu, position.current().call())

    def text_of(self, fmu: str, call: Call | None) -> str:
        """Return what an FMU said in a call, if that was the last in which it spoke."""
        told = self._of_call.get(fmu)
        return told.text() if told is not None and told.belongs_to(call) else ""

    def summary(self) -> list[Said]:
        """Return warnings and errors so far, alike ones counted."""
        self.collect()
        return list(self._said.values())

    def forget(self, fmu: str) -> None:
        """Drop what an FMU said of an attempt that is made again in another way."""
        self._of_call.pop(fmu, None)
        self._said = {key: said for key, said in self._said.items() if key[0] != fmu}

    def state(self) -> dict[str, Any]:
        """Return warnings and errors so far and the end of the file, for JSON; `restore` takes it."""
        said = [[*key, one.t, one.count] for key, one in self._said.items()]
        return {"said": said, "file": None if self._file is None else self._file.mark()}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to what `state` returned, in the same process or another one."""
        self._of_call.clear()
        self._said = {
            (fmu, status, category, text): Said(fmu, status_name(status), category, text, t, count)
            for fmu, status, category, text, t, count in state["said"]
        }
        if self._file is not None and state["file"] is not None:
            self._file.restore(state["file"])

    def _count(self, fmu: str, message: _Message, t: float | None) -> None:
        key = (fmu, message.status, message.category, message.text)
        if key not in self._said and sum(1 for k in self._said if k[0] == fmu) >= _MOST_DIFFERENT:
            key = (fmu, message.status, message.category, _OTHERS)
        if key in self._said:
            self._said[key].count += 1
            return
        self._said[key] = Said(fmu, status_name(message.status), message.category, key[3], t)
        if self._changed is not None:
            self._changed(self, fmu)


class LogFile:
    """
    A text file of messages from a level on, one a line; the same one again and again is counted.

    What the folder does not take is left out: messages are in the summary too.
    """

    def __init__(self, path: Path, level: str, *, goes_on: bool = False) -> None:
        """Open it; one that `goes_on` keeps what an earlier run wrote until it is restored."""
        self.path = path
        self._least = LEVELS[level]
        self._file: IO[str] | None = None
        with contextlib.suppress(OSError):
            self._file = path.open("a" if goes_on else "w", encoding="utf-8", buffering=1)
        self._last: tuple[str, int, str] | None = None
        self._repeats = 0
        self._n_bytes = 0

    def write(self, fmu: str, status: int, text: str, t: float | None) -> None:
        """Write a message that came at t [s] if it is of the level."""
        if self._file is None or _severity(status) < self._least:
            return
        if (fmu, status, text) == self._last:
            self._repeats += 1
            return
        self._last = fmu, status, text
        self._write_repeats()
        self._line(
            f"{'before the start' if t is None else f't={t:.9g} s'}  {fmu}  {status_name(status)}  {text}"
        )

    def mark(self) -> dict[str, Any] | None:
        """Return where the file ends now and what is counted; None if it takes no more."""
        if self._file is None:
            return None
        try:
            size = os.fstat(self._file.fileno()).st_size
        except OSError:
            return None
        return {"size": size, "bytes": self._n_bytes, "last": self._last, "repeats": self._repeats}

    def restore(self, mark: dict[str, Any]) -> None:
        """Drop what was written after a mark."""
        if self._file is None:
            return
        with contextlib.suppress(OSError):
            os.ftruncate(self._file.fileno(), mark["size"])
        self._n_bytes = mark["bytes"]
        self._last = None if mark["last"] is None else tuple(mark["last"])
        self._repeats = mark["repeats"]

    def close(self) -> None:
        """End the file; one without messages is removed."""
        self.end()
        with contextlib.suppress(OSError):
            if self.path.stat().st_size == 0:
                self.path.unlink()

    def end(self) -> None:
        """Write what is to be written, in a process that shares the file."""
        self._write_repeats()
        if self._file is not None:
            with contextlib.suppress(OSError):
                self._file.close()

    def _write_repeats(self) -> None:
        if self._repeats:
            self._line(f"    ... and {self._repeats} times more")
            self._repeats = 0

    def _line(self, text: str) -> None:
        if self._file is None:
            return
        self._n_bytes += len(text.encode(errors="replace")) + 1
        is_full = self._n_bytes > _MOST_BYTES
        try:
            self._file.write("... no more is written: the file has 50 MB\n" if is_full else f"{text}\n")
        except OSError:
            is_full = True
        if is_full:
            with contextlib.suppress(OSError):
                self._file.close()
            self._file = None


def _severity(status: int) -> int:
    """Order of statuses; one that FMI does not define counts as fatal."""
    return status if Status.OK <= status <= Status.FATAL else Status.FATAL + 1


def as_dicts(said: list[Said]) -> list[dict[str, Any]]:
    """Return messages for JSON."""
    return [asdict(one) for one in said]


_current = MessageLog()


def current() -> MessageLog:
    """Return the log of the run in this process."""
    return _current


@contextmanager
def collecting(log: MessageLog) -> Iterator[MessageLog]:
    """Collect the messages of FMUs in a log."""
    global _current
    before = _current
    _current = log
    try:
        yield log
    finally:
        _current = before
