"""The stepping loop: executes the flat program tick by tick and records. One function, compiled or not."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from . import calls
from .calls import BOOL32, FLOAT64
from .program import COPY, GET, KEEP, SET, STEP, Program

DONE, FAILED, OUT_OF_LIMITS = 0, 1, 2
WARNING = 1

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@register_jitable
def _as_integer(value: float, kind: int) -> int:
    """Whole number of a value on its way into an integer or Boolean input."""
    if kind == BOOL32:
        return 1 if value != 0.0 else 0
    return int(np.rint(value))


def execute(
    program: tuple[Any, ...], grid: tuple[float, float], ticks: tuple[int, int], rows: Floats, limits: Floats
) -> tuple[int, int, int, int]:
    """
    Execute ticks and record one row after each.

    Args:
        program: Arrays of `Program`: operations, blocks, slaves, conversions, values, rings, record.
        grid: t0 [s] and step size h [s]; tick k goes from t0 + k h to t0 + (k+1) h.
        ticks: First tick and the one behind the last.
        rows: Values after each tick, shape (ticks, recorded signals), written.
        limits: Largest allowed magnitude of each recorded signal, shape (recorded signals,).

    Returns:
        Outcome, number of complete ticks, operation (FAILED) or signal (OUT_OF_LIMITS), FMI status.
    """
    operations, blocks, slaves, conversions, values, rings, record = program
    t0, h = grid
    first, end = ticks
    base = values.ctypes.data
    scratch = np.empty(max(1, values.size), dtype=np.int32)
    integers = scratch.ctypes.data
    for k in range(first, end):
        for i in range(operations.shape[0]):
            code, every, a, b, c, d = operations[i]
            if (k + 1) % every != 0:
                continue
            status = 0
            if code == COPY:
                values[b] = conversions[c, 0] * values[a] + conversions[c, 1]
            elif code == KEEP:
                cell = c + k % d
                oldest = rings[cell]
                rings[cell] = values[a]
                values[b] = oldest
            elif code == STEP:
                start = t0 + (k + 1 - every) * h
                status = calls.do_step(b, slaves[a], start, every * h)
            elif code == SET:
                references, n, place, kind = blocks[c]
                if kind == FLOAT64:
                    status = calls.exchange(b, slaves[a], references, n, base + 8 * place)
                else:
                    for j in range(n):
                        scratch[j] = _as_integer(values[place + j], kind)
                    status = calls.exchange(b, slaves[a], references, n, integers)
            elif code == GET:
                references, n, place, kind = blocks[c]
                if kind == FLOAT64:
                    status = calls.exchange(b, slaves[a], references, n, base + 8 * place)
                else:
                    status = calls.exchange(b, slaves[a], references, n, integers)
                    for j in range(n):
                        values[place + j] = scratch[j]
            if status > WARNING:
                return FAILED, k - first, i, status
        for j in range(record.size):
            value = values[record[j]]
            rows[k - first, j] = value
            if not (abs(value) <= limits[j]):
                return OUT_OF_LIMITS, k - first + 1, j, 0
    return DONE, end - first, 0, 0


def arrays(program: Program, record: Integers) -> tuple[Any, ...]:
    """Arrays that `execute` works on; `record` holds places in the table of values."""
    p = program
    return (p.operations, p.blocks, p.slaves, p.conversions, p.values, p.rings, record)


@lru_cache(maxsize=1)
def compiled() -> Callable[..., tuple[int, int, int, int]]:
    """Give `execute` as numba-compiled code, kept on disk between processes."""
    from numba import njit

    return njit(cache=True)(execute)
