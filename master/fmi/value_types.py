"""The value types of FMI variables: their codes, names and sizes, and the way between them and doubles."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba.extending import register_jitable

FLOAT64, FLOAT32, INT8, UINT8, INT16, UINT16, INT32, UINT32, INT64, UINT64, BOOLEAN = range(11)
INT_BOOLEAN = 11  # the Boolean of FMI 2.0, an int

NAMES = (
    "Float64",
    "Float32",
    "Int8",
    "UInt8",
    "Int16",
    "UInt16",
    "Int32",
    "UInt32",
    "Int64",
    "UInt64",
    "Boolean",
)

LARGEST_SIZE = 8

# least and largest value of each whole type; those of 64 bits as far as a double tells them apart
RANGES = {
    **{t: (-(2.0 ** (n - 1)), 2.0 ** (n - 1) - 1.0) for t, n in ((INT8, 8), (INT16, 16), (INT32, 32))},
    **{t: (0.0, 2.0**n - 1.0) for t, n in ((UINT8, 8), (UINT16, 16), (UINT32, 32))},
    INT64: (-(2.0**63), 2.0**63 - 1024.0),
    UINT64: (0.0, 2.0**64 - 2048.0),
}


_LEAST = np.array([RANGES.get(t, (-math.inf, math.inf))[0] for t in range(INT_BOOLEAN + 1)])
_LARGEST = np.array([RANGES.get(t, (-math.inf, math.inf))[1] for t in range(INT_BOOLEAN + 1)])


@register_jitable
def first_misfit(values: Any, place: int, n: int, kind: int) -> int:
    """Place of the first of n doubles from `place` on that a whole type cannot hold; -1 if there is none."""
    if _LARGEST[kind] < np.inf:
        for j in range(place, place + n):
            if not (_LEAST[kind] <= np.rint(values[j]) <= _LARGEST[kind]):
                return j
    return -1


@register_jitable
def pack(values: Any, place: int, n: int, kind: int, scratch: Any) -> None:
    """Write n doubles from `place` on into the bytes of `scratch` as values of a type that holds them."""
    if kind == FLOAT32:
        floats = scratch.view(np.float32)
        for j in range(n):
            floats[j] = values[place + j]
    elif kind == BOOLEAN:
        for j in range(n):
            scratch[j] = 1 if values[place + j] != 0.0 else 0
    elif kind == INT_BOOLEAN:
        truths = scratch.view(np.int32)
        for j in range(n):
            truths[j] = 1 if values[place + j] != 0.0 else 0
    elif kind in (INT8, UINT8):
        for j in range(n):
            scratch[j] = np.int64(np.rint(values[place + j])) & 0xFF
    elif kind in (INT16, UINT16):
        shorts = scratch.view(np.uint16)
        for j in range(n):
            shorts[j] = np.int64(np.rint(values[place + j])) & 0xFFFF
    elif kind in (INT32, UINT32):
        words = scratch.view(np.uint32)
        for j in range(n):
            words[j] = np.int64(np.rint(values[place + j])) & 0xFFFFFFFF
    else:
        longs = scratch.view(np.int64)
        for j in range(n):
            longs[j] = np.int64(np.rint(values[place + j]))


@register_jitable
def unpack(values: Any, place: int, n: int, kind: int, scratch: Any) -> None:
    """Read n values of a type from the bytes of `scratch` into doubles from `place` on."""
    if kind == FLOAT32:
        _copy(values, place, n, scratch.view(np.float32))
    elif kind == INT8:
        _copy(values, place, n, scratch.view(np.int8))
    elif kind in (UINT8, BOOLEAN):
        _copy(values, place, n, scratch)
    elif kind == INT16:
        _copy(values, place, n, scratch.view(np.int16))
    elif kind == UINT16:
        _copy(values, place, n, scratch.view(np.uint16))
    elif kind in (INT32, INT_BOOLEAN):
        _copy(values, place, n, scratch.view(np.int32))
    elif kind == UINT32:
        _copy(values, place, n, scratch.view(np.uint32))
    elif kind == INT64:
        _copy(values, place, n, scratch.view(np.int64))
    else:
        _copy(values, place, n, scratch.view(np.uint64))


@register_jitable
def _copy(values: Any, place: int, n: int, typed: Any) -> None:
    for j in range(n):
        values[place + j] = typed[j]
