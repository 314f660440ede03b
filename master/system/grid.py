"""The time grid of a run."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

SHARE_OF_A_TICK = Fraction(1, 10**6)  # what is nearer to a tick is meant to be it


@lru_cache(maxsize=64)
def ticks_between(begin: float, end: float, step_size: float) -> Fraction:
    """
    Number of steps from one time to another [s], without a rounding.

    The times are taken as they are written, not as they are stored: of 31536000.999 s a double keeps
    31536000.99899999..., which is ticks of 1 ms and a part of one.
    """
    return (Fraction(repr(float(end))) - Fraction(repr(float(begin)))) / Fraction(repr(float(step_size)))


@dataclass(frozen=True)
class Grid:
    """The time grid: tick k goes from t0 + k h to t0 + (k+1) h [s]."""

    t0: float
    step_size: float
    n_ticks: int

    def time(self, tick: int) -> float:
        """Start of a tick [s], computed without accumulation."""
        return self.t0 + tick * self.step_size

    def tick_at(self, time: float) -> int:
        """
        First tick that does not begin before a time [s].

        A time that is later than the begin of a tick by a millionth of a tick, or by the rounding of a time
        that was computed, is the begin of that tick.
        """
        rounding = Fraction(math.ulp(time)) / Fraction(self.step_size)
        tolerance = min(Fraction(1, 2), SHARE_OF_A_TICK + rounding)
        return math.ceil(ticks_between(self.t0, time, self.step_size) - tolerance)

    def ticks_of(self, duration: float) -> int:
        """Number of ticks that a duration [s] lasts, at least one."""
        return max(1, math.ceil(ticks_between(0.0, duration, self.step_size) - SHARE_OF_A_TICK))

    def stop(self, lengths: Iterable[int] = ()) -> float:
        """
        Time that no step goes beyond [s]; `lengths` of steps in ticks besides 1.

        A step ends at its start plus its length, which may be one rounding after the time of the last row; an
        FMU that is told the stop time refuses to step beyond it.
        """
        ends = [self.time(self.n_ticks)]
        ends += [self.time(self.n_ticks - n) + n * self.step_size for n in (1, *lengths) if n <= self.n_ticks]
        return max(ends)
