"""The value types of FMI variables: their codes and names."""

from __future__ import annotations

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

LONG = (INT64, UINT64)  # types of which a double does not hold all digits
MOST_EXACT = 2**53 - 1  # a double of 2^53 may have been 2^53 + 1

_LARGEST_FLOAT32 = (2.0 - 2.0**-23) * 2.0**127
_WIDTHS = {INT8: 8, UINT8: 8, INT16: 16, UINT16: 16, INT32: 32, UINT32: 32, INT64: 64, UINT64: 64}
_UNSIGNED = (UINT8, UINT16, UINT32, UINT64)

# least and largest value that a type itself holds
TYPE_RANGES: dict[int, tuple[float, float]] = {
    FLOAT32: (-_LARGEST_FLOAT32, _LARGEST_FLOAT32),
    **{
        t: (0, 2**n - 1) if t in _UNSIGNED else (-(2 ** (n - 1)), 2 ** (n - 1) - 1)
        for t, n in _WIDTHS.items()
    },
}

# what a wire may carry to a type, as a double: one from 2^53 on may be another integer than its source's
RANGES: dict[int, tuple[float, float]] = {
    t: (float(max(least, -MOST_EXACT)), float(min(largest, MOST_EXACT)))
    if t in LONG
    else (float(least), float(largest))
    for t, (least, largest) in TYPE_RANGES.items()
}
