"""Counts of a converter or an encoder: two's complement, and the ends of its counter."""

from __future__ import annotations

import numpy as np

from master.diagnosis.numerics.arrays import Array


def signed(values: Array, bits: int) -> Array:
    """
    Read counts of some bits in two's complement as numbers with a sign; numbers with a sign stay.

    Raises:
        ValueError: If a value is no integer or does not fit in the bits.
    """
    whole = 2.0**bits
    wrong = np.flatnonzero((values != np.round(values)) | (values >= whole) | (values < -0.5 * whole))
    if len(wrong):
        got = f"{values[wrong[0]]:g} in row {wrong[0]} of the data"
        raise ValueError(f"bits, got {got}, expected integers from {-0.5 * whole:.0f} to {whole - 1.0:.0f}")
    if np.any(values < 0.0) and np.any(values >= 0.5 * whole):
        raise ValueError(
            f"bits, got values below 0 and from {0.5 * whole:.0f} on, expected one way to count, or more bits"
        )
    return np.where(values >= 0.5 * whole, values - whole, values)


def unwrapped(values: Array, bits: int) -> Array:
    """
    Follow a counter over its ends: from row to row it moves by less than half of its range.

    Raises:
        ValueError: If it moves by so much that its way is not known.
    """
    whole = 2.0**bits
    steps = np.diff(values)
    steps -= whole * np.round(steps / whole)
    wrong = np.flatnonzero(np.abs(steps) > 0.25 * whole)
    if len(wrong):
        raise ValueError(
            f"wraps, got {steps[wrong[0]]:g} counts in a step at row {wrong[0] + 1} of the data, "
            f"expected less than a quarter of the {whole:.0f} of {bits} bits: which way it went is not known"
        )
    return np.concatenate([values[:1], values[0] + np.cumsum(steps)])
