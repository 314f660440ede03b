"""What every runner measures and answers on standard output: time per step, version, final values."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterable


def timed(function: Callable[[], object]) -> tuple[float, float]:
    """Call a function; give wall time and processor time of all threads [s]."""
    begin, begin_cpu = time.perf_counter(), time.process_time()
    function()
    return time.perf_counter() - begin, time.process_time() - begin_cpu


def answer(
    seconds: tuple[float, float], n_steps: int, version: str, final: Iterable[tuple[str, float]]
) -> None:
    """
    Print one JSON object as the last line.

    The smaller of wall time and processor time counts: on a busy machine the wall time of a single
    thread holds the waiting for a processor, and the processor time of several threads their sum.
    """
    found = {"us_per_step": 1e6 * min(seconds) / n_steps, "version": version, "final": dict(final)}
    sys.stdout.write("\n" + json.dumps(found) + "\n")
