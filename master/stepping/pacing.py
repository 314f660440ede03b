"""
Real time: each tick begins at its absolute release; how late it began is counted, and why the worst ones did.

The waiting itself is in the stepping loop (`machine/pace.py`). Here is what surrounds it: the table that it
writes, what the process asks of the system (memory, priority, core), and the report.
"""

from __future__ import annotations

import ctypes
import gc
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

_BINS_MS = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 100.0)
_MOST_SPIN_NS = 150_000
_SPIN_SHARE = 0.3  # of a period: the rest is left to others, also under real-time priority
_CHUNK_SECONDS = 0.1
_BEGIN_NS = 2_000_000  # from now to the release of tick 0
_FIRST_SECOND_NS = 1_000_000_000

_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4
_M_TRIM_THRESHOLD, _M_MMAP_MAX = -1, -4
_PR_SET_TIMERSLACK = 29
_MADV_POPULATE_WRITE = 23
_MOST_OWNED = 2**26  # bytes of a mapping

CONTINUE, STOP = "continue", "stop"

if sys.platform != "win32":
    import resource

Integers = NDArray[np.int64]


@dataclass
class Pacer:
    """
    Releases tick k at start + k h / factor.

    `factor` is simulated seconds a second. A tick whose work is not done at the release of the next one
    is an overrun; with `on_overrun` stop, the run ends there. `priority` is one of SCHED_FIFO (1 to 99),
    `core` the processor that the run stays on; None leaves them to the system.
    """

    factor: float = 1.0
    on_overrun: str = CONTINUE
    priority: int | None = None
    core: int | None = None
    chunk: int = 1
    notes: list[str] = field(default_factory=list)
    _cells: Integers | None = None
    _faults: tuple[int, int] | None = None

    @contextmanager
    def pacing(self, step_size: float, room: NDArray[np.float64]) -> Iterator[None]:
        """
        Prepare for ticks; no garbage is collected meanwhile, for a full collection lasts many ticks.

        Args:
            step_size: Length of a tick [s] of simulated time.
            room: Memory that rows will be written to, which is touched before.
        """
        from .machine import pace

        was_on = gc.isenabled()
        gc.collect()
        gc.disable()
        period = 1e9 * step_size / self.factor
        cells = np.zeros(pace.N_CELLS, dtype=np.int64)
        cells[pace.SLEEP], cells[pace.CLOCK] = _clock_functions()
        cells[pace.PERIOD : pace.PERIOD + 1].view(np.float64)[0] = period
        cells[pace.SPIN] = int(min(_MOST_SPIN_NS, _SPIN_SHARE * period))
        cells[pace.STOPS] = self.on_overrun == STOP
        cells[pace.WORST : pace.HISTOGRAM : pace.WORST_WIDTH] = -1
        self._cells = cells
        self.chunk = max(1, int(1e9 * _CHUNK_SECONDS / period))
        self._ask_the_system()
        room.fill(0.0)
        try:
            yield
        finally:
            if was_on:
                gc.enable()

    def begin(self) -> None:
        """Let tick 0 be released in a moment."""
        from .machine import pace

        assert self._cells is not None, "not pacing"
        self._cells[pace.START] = time.monotonic_ns() + _BEGIN_NS

    def address(self, tick: int) -> int | None:
        """Address of the cells, for an execution that begins with a tick; None while nothing is paced."""
        from .machine import pace

        if self._cells is None:
            return None
        self._cells[pace.FIRST] = tick
        if self._faults is None and tick and time.monotonic_ns() - self._cells[pace.START] > _FIRST_SECOND_NS:
            self._faults = _faults_and_switches()
        return int(self._cells.ctypes.data)

    def report(self) -> dict[str, Any]:
        """
        Lateness of the starts [ms]: median, 99 %, worst with its tick and cause, histogram; overruns.

        Median and 99 % are those of bins of 1 us. `page_faults` and `involuntary_switches` are those of the
        stepping thread after the first second, None in a shorter run.
        """
        from .machine import pace

        if self._cells is None or self._cells[pace.TICKS] == 0:
            return {}
        cells = self._cells
        counts = cells[pace.HISTOGRAM :]
        total = np.cumsum(counts)
        rows = cells[pace.WORST : pace.HISTOGRAM].reshape(-1, pace.WORST_WIDTH)
        worst = sorted((r for r in rows.tolist() if r[0] >= 0), reverse=True)
        edges = [round(1e6 * low / pace.BIN_NS) for low in _BINS_MS]
        bins = [int(counts[a:b].sum()) for a, b in zip(edges, [*edges[1:], None], strict=True)]
        names = [f"{low:g}..{high:g} ms" for low, high in zip(_BINS_MS, (*_BINS_MS[1:], np.inf), strict=True)]
        now = _faults_and_switches()
        since = None if self._faults is None else [b - a for a, b in zip(self._faults, now, strict=True)]
        return {
            "factor": self.factor,
            "median_ms": _quantile(total, 0.5),
            "p99_ms": _quantile(total, 0.99),
            "p999_ms": _quantile(total, 0.999),
            "worst_ms": 1e-6 * worst[0][0],
            "worst_tick": worst[0][1],
            "worst": [_worst(row) for row in worst],
            "overruns": int(cells[pace.OVERRUNS]),
            "page_faults": None if since is None else since[0],
            "involuntary_switches": None if since is None else since[1],
            "notes": self.notes,
            "histogram": dict(zip(names, bins, strict=True)),
        }

    def _ask_the_system(self) -> None:
        """Lock memory, take core and priority; what the system refuses is noted, with what it would need."""
        if not sys.platform.startswith("linux"):
            return
        libc = ctypes.CDLL(None, use_errno=True)
        with_mallopt = getattr(libc, "mallopt", None)  # glibc's: memory that was given back would fault again
        if with_mallopt is not None:
            with_mallopt(_M_MMAP_MAX, 0)
            with_mallopt(_M_TRIM_THRESHOLD, 2**30)
        libc.prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
        _own_all_pages(libc)
        if libc.mlockall(_MCL_CURRENT | _MCL_FUTURE | _MCL_ONFAULT) != 0:
            self._note("memory is not locked", "CAP_IPC_LOCK or a larger `ulimit -l`")
        if self.core is not None:
            try:
                os.sched_setaffinity(0, {self.core})
            except OSError:
                self._note(f"not on core {self.core}", f"one of {sorted(os.sched_getaffinity(0))}")
        if self.priority is not None:
            try:
                os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(self.priority))
            except OSError:
                needs = "CAP_SYS_NICE or an `rtprio` in /etc/security/limits.conf"
                self._note(f"no real-time priority {self.priority}", needs)

    def _note(self, what: str, needs: str) -> None:
        self.notes.append(f"{what}, expected {needs}")


def _own_all_pages(libc: Any) -> None:
    """Let this process have its own copy of each page that it may write: a fork shares them until then."""
    libc.madvise.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int]
    try:
        with open("/proc/self/maps", encoding="utf-8") as file:
            lines = file.read().splitlines()
    except OSError:
        return
    for line in lines:
        place, kind = line.split()[:2]
        first, after = (int(address, 16) for address in place.split("-"))
        if kind == "rw-p" and after - first <= _MOST_OWNED:
            libc.madvise(first, after - first, _MADV_POPULATE_WRITE)  # fails without harm before Linux 5.14


def _worst(row: list[int]) -> dict[str, Any]:
    from .machine import pace

    late, tick, cause, work = row
    causes = {
        pace.WOKEN_LATE: "woken late by the system",
        pace.WORKED_LONG: f"the tick before took {1e-6 * work:.3f} ms",
        pace.BETWEEN: "between ticks: events, progress, or the system took the processor away",
    }
    return {"late_ms": 1e-6 * late, "tick": tick, "cause": causes[cause]}


def _quantile(total: Integers, share: float) -> float:
    """Lateness [ms] that a share of the ticks do not exceed, the upper end of its bin."""
    from .machine import pace

    place = int(np.searchsorted(total, share * total[-1]))
    return 1e-6 * pace.BIN_NS * (place + 1)


def _faults_and_switches() -> tuple[int, int]:
    if sys.platform == "win32":
        return 0, 0
    who = getattr(resource, "RUSAGE_THREAD", resource.RUSAGE_SELF)
    used = resource.getrusage(who)
    return used.ru_minflt + used.ru_majflt, used.ru_nivcsw


_kept_functions: list[Any] = []


def _clock_functions() -> tuple[int, int]:
    """Addresses of clock_nanosleep and clock_gettime; of functions in Python where the system has none."""
    from master.fmi.native import calls

    if sys.platform.startswith("linux"):
        libc = ctypes.CDLL(None)
        found = (libc.clock_nanosleep, libc.clock_gettime)
    else:
        found = (
            ctypes.CFUNCTYPE(*calls.CLOCK_SLEEP)(_sleep_until),
            ctypes.CFUNCTYPE(*calls.CLOCK_TIME)(_tell_time),
        )
        _kept_functions.extend(found)
    sleep, clock = (ctypes.cast(f, ctypes.c_void_p).value or 0 for f in found)
    return sleep, clock


def _sleep_until(_: int, __: int, place: int, ___: int | None) -> int:
    seconds, nanoseconds = (ctypes.c_int64 * 2).from_address(place)
    time.sleep(max(0.0, 1e-9 * (seconds * 10**9 + nanoseconds - time.monotonic_ns())))
    return 0


def _tell_time(_: int, place: int) -> int:
    (ctypes.c_int64 * 2).from_address(place)[:] = list(divmod(time.monotonic_ns(), 10**9))
    return 0
