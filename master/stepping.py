"""The stepping loop: executes the flat program tick by tick and records. One function, compiled or not."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from . import calls
from .program import COPY, KEEP, SET, STEP, Program
from .value_types import FLOAT64, LARGEST_SIZE, pack, unpack

DONE, FAILED, OUT_OF_LIMITS = 0, 1, 2
WARNING = 1
_COMPILED = ("stepping", "calls", "program", "value_types")

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@register_jitable
def _exchange(slave: Integers, function: int, block: Integers, data: int) -> int:
    references, n = block[0], block[1]
    if slave[1] == 2:
        return calls.exchange(function, slave[0], references, n, data)
    return calls.exchange_3(function, slave[0], references, n, data)


@register_jitable
def _do_step(slave: Integers, function: int, t: float, h: float, scratch: int) -> int:
    if slave[1] == 2:
        return calls.do_step(function, slave[0], t, h)
    return calls.do_step_3(function, slave[0], t, h, scratch)


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
    scratch = np.zeros(LARGEST_SIZE * max(4, values.size), dtype=np.uint8)
    scratch_base = scratch.ctypes.data
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
                status = _do_step(slaves[a], b, start, every * h, scratch_base)
            elif blocks[c, 3] == FLOAT64:
                status = _exchange(slaves[a], b, blocks[c], base + 8 * blocks[c, 2])
            elif code == SET:
                pack(values, blocks[c, 2], blocks[c, 1], blocks[c, 3], scratch)
                status = _exchange(slaves[a], b, blocks[c], scratch_base)
            else:
                status = _exchange(slaves[a], b, blocks[c], scratch_base)
                unpack(values, blocks[c, 2], blocks[c, 1], blocks[c, 3], scratch)
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

    dispatcher = njit(cache=True)(execute)
    # numba looks at this file alone and would load old code where only a function it calls has changed
    dispatcher._cache._cache_file._source_stamp = _stamp()  # type: ignore[attr-defined]
    return dispatcher


def _stamp() -> str:
    folder = Path(__file__).parent
    texts = [(folder / f"{name}.py").read_bytes() for name in _COMPILED]
    return hashlib.sha256(b"".join(texts)).hexdigest()
