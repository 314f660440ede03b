"""
Real time within the stepping loop: each tick waits for its release, without Python.

All is in one table of cells of 8 bytes, whose address is handed on: integers, but for `PERIOD`. Times are
those of the system's monotonic clock [ns].
"""

from __future__ import annotations

from master.fmi.native import calls
from master.fmi.native.cells import integer_at, load, store
from master.fmi.native.jit import inner
from master.fmi.value_types import FLOAT64, INT64

# Cells. WAKE and NOW are pairs of seconds and nanoseconds, as the C functions have them.
SLEEP, CLOCK = 0, 1  # addresses of clock_nanosleep and clock_gettime
START, PERIOD, SPIN = 2, 3, 4  # release of tick 0, length of a tick (a double), how long to wait awake
WAKE, NOW = 5, 7
STOPS = 9  # 1 if a tick that is not done in time ends the execution
FIRST = 10  # first tick of this execution
BEGUN, WORK = 11, 12  # when the work of the present tick began; how long that of the last one took
OVERRUNS, TICKS = 13, 14
N_WORST, WORST = 10, 15  # rows [lateness, tick, cause, work of the tick before]
WORST_WIDTH = 4
HISTOGRAM = WORST + N_WORST * WORST_WIDTH
N_BINS, BIN_NS = 100_001, 1000  # the last bin has all that is later
N_CELLS = HISTOGRAM + N_BINS

WOKEN_LATE, WORKED_LONG, BETWEEN = 0, 1, 2
"""Why a tick begins late: the system woke it late, the tick before took too long, events or progress did."""

_BILLION = 1_000_000_000


@inner
def now(pace: int) -> int:
    """Time of the clock."""
    calls.clock_time(integer_at(pace, CLOCK), pace + 8 * NOW)
    return integer_at(pace, NOW) * _BILLION + integer_at(pace, NOW + 1)


@inner
def release_of(pace: int, k: int) -> int:
    """Time at which a tick may begin."""
    return integer_at(pace, START) + int(k * load(pace, PERIOD, FLOAT64))


@inner
def wait_for(pace: int, k: int) -> None:
    """Wait for the release of tick k, asleep first and awake for the last part; note how late it begins."""
    release = release_of(pace, k)
    time = now(pace)
    cause = WOKEN_LATE
    if time >= release:
        cause = BETWEEN if k == integer_at(pace, FIRST) else WORKED_LONG
    wake = release - integer_at(pace, SPIN)
    if time < wake:
        store(pace, WAKE, INT64, float(wake // _BILLION))
        store(pace, WAKE + 1, INT64, float(wake % _BILLION))
        calls.clock_sleep(integer_at(pace, SLEEP), pace + 8 * WAKE)
    while time < release:
        time = now(pace)
    _note(pace, k, time - release, cause)
    store(pace, BEGUN, INT64, float(time))


@inner
def is_overrun(pace: int, k: int) -> bool:
    """Note the end of tick k; whether it is later than the release of the next one."""
    time = now(pace)
    store(pace, WORK, INT64, float(time - integer_at(pace, BEGUN)))
    is_late = time > release_of(pace, k + 1)
    if is_late:
        store(pace, OVERRUNS, INT64, float(integer_at(pace, OVERRUNS) + 1))
    return is_late


@inner
def _note(pace: int, k: int, late: int, cause: int) -> None:
    store(pace, TICKS, INT64, float(integer_at(pace, TICKS) + 1))
    cell = HISTOGRAM + min(late // BIN_NS, N_BINS - 1)
    store(pace, cell, INT64, float(integer_at(pace, cell) + 1))
    least = WORST
    for j in range(WORST, HISTOGRAM, WORST_WIDTH):
        if integer_at(pace, j) < integer_at(pace, least):
            least = j
    if late > integer_at(pace, least):
        store(pace, least, INT64, float(late))
        store(pace, least + 1, INT64, float(k))
        store(pace, least + 2, INT64, float(cause))
        store(pace, least + 3, INT64, float(integer_at(pace, WORK)))
