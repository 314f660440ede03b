"""The value types of FMI variables: their codes and names."""

from __future__ import annotations

Value = bool | int | float | str  # of a parameter or a start value, as a user writes it

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

# least and largest value of each whole type; those of 64 bits as far as a double tells them apart
RANGES = {
    **{t: (-(2.0 ** (n - 1)), 2.0 ** (n - 1) - 1.0) for t, n in ((INT8, 8), (INT16, 16), (INT32, 32))},
    **{t: (0.0, 2.0**n - 1.0) for t, n in ((UINT8, 8), (UINT16, 16), (UINT32, 32))},
    INT64: (-(2.0**63), 2.0**63 - 1024.0),
    UINT64: (0.0, 2.0**64 - 2048.0),
}
