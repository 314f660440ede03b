"""Real time: each tick waits for its absolute deadline, and how late it started is kept."""

from __future__ import annotations

import gc
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

_SPIN = 300e-6
_BINS_MS = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 100.0)

CONTINUE, STOP = "continue", "stop"


@dataclass
class Pacer:
    """
    Releases tick k at start + k h / factor.

    `factor` is simulated seconds a second. A tick whose work is not done at the release of the next one
    is an overrun; with `on_overrun` stop, the run ends there.
    """

    factor: float = 1.0
    on_overrun: str = CONTINUE
    overruns: int = 0
    lateness: list[float] = field(default_factory=list)
    _start: float = 0.0

    @contextmanager
    def pacing(self) -> Iterator[None]:
        """Begin with tick 0; no garbage is collected meanwhile, for a full collection lasts many ticks."""
        was_on = gc.isenabled()
        gc.collect()
        gc.disable()
        self.begin()
        try:
            yield
        finally:
            if was_on:
                gc.enable()

    def begin(self) -> None:
        """Set the time of tick 0."""
        self._start = time.perf_counter()

    def wait(self, tick: int, step_size: float) -> None:
        """Wait for the release of a tick: asleep first, awake for the last fraction of a millisecond."""
        release = self._start + tick * step_size / self.factor
        left = release - time.perf_counter()
        if left > _SPIN:
            time.sleep(left - _SPIN)
        while (now := time.perf_counter()) < release:
            pass
        self.lateness.append(now - release)

    def done(self, tick: int, step_size: float) -> bool:
        """Note the end of a tick; give whether the run may go on."""
        late = time.perf_counter() > self._start + (tick + 1) * step_size / self.factor
        self.overruns += late
        return not (late and self.on_overrun == STOP)

    def report(self) -> dict[str, Any]:
        """Lateness of the starts [ms]: median, 99 %, worst with its tick, histogram; number of overruns."""
        late = 1e3 * np.array(self.lateness)
        if not len(late):
            return {}
        counts, _ = np.histogram(late, bins=(*_BINS_MS, np.inf))
        names = [f"{low:g}..{high:g} ms" for low, high in zip(_BINS_MS, (*_BINS_MS[1:], np.inf), strict=True)]
        return {
            "factor": self.factor,
            "median_ms": float(np.median(late)),
            "p99_ms": float(np.percentile(late, 99.0)),
            "worst_ms": float(late.max()),
            "worst_tick": int(late.argmax()),
            "overruns": self.overruns,
            "histogram": dict(zip(names, map(int, counts), strict=True)),
        }
