"""Counts of a converter or an encoder, and angles: two's complement, and the ends of their range."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from master.diagnosis.numerics.arrays import Array, Integers

_ANGLES = [2.0 * math.pi, 360.0, 400.0]
_ANGLES_OF_INTEGERS = [360.0, 3600.0, 36000.0, 360000.0]
_MOST_OF_RANGE = 0.25  # in a row: beyond, a step may be one the other way round
_MOST_JUMPS = 0.2  # of the rows
_MOST_OVER = 1.5  # step over the ends, over the largest of the others
_MOST_FITTING = 0.9  # of the jumps
_NEIGHBOURS = 4  # rows on both sides of a jump


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


def unwrapped(values: Array, whole: float) -> Array:
    """
    Follow a counter or an angle over the ends of its range: it moves by less than a quarter of that in a row.

    Args:
        values: As recorded, shape (n,).
        whole: The range, in their unit: 2 to the number of bits, 360 degrees, ...

    Raises:
        ValueError: If they span more than the range, or move by so much that their way is not known.
    """
    if np.ptp(values) > whole:
        raise ValueError(f"wraps, got values that span {np.ptp(values):g}, expected {whole:g} at most")
    steps = np.diff(values)
    steps -= whole * np.round(steps / whole)
    wrong = np.flatnonzero(np.abs(steps) > _MOST_OF_RANGE * whole)
    if len(wrong):
        raise ValueError(
            f"wraps, got {steps[wrong[0]]:g} in a step at row {wrong[0] + 1} of the data, expected less than "
            f"a quarter of the range of {whole:g}: which way it went is not known"
        )
    turns = np.concatenate([[0.0], np.cumsum(np.round((steps - np.diff(values)) / whole))])
    return np.asarray(values + whole * turns)


@dataclass(frozen=True)
class Wrap:
    """
    A column that goes over the ends of its range, `times` in all; `whole` is that range in its own unit.

    `is_known`: the range is one that counters and angles have; else it is read from the jumps. `bits`: it
    lies around zero in two's complement, and never at the other end of its range.
    """

    whole: float
    times: int
    is_known: bool
    bits: int | None = None

    @property
    def entry(self) -> str:
        """What a signal of a case says of it."""
        return f"bits: {self.bits}" if self.bits is not None else f"wraps: {_written(self.whole)}"

    def followed(self, values: Array) -> Array:
        """Values with a sign, or over the ends of their range."""
        return unwrapped(values, self.whole) if self.bits is None else signed(values, self.bits)

    def __str__(self) -> str:
        ends = f"jumps {self.times} times over the ends of a range of {self.whole:.7g}"
        if self.bits is not None:
            return f"{ends}: {self.bits} bits in two's complement"
        return f"{ends}, as a counter or an angle does" + ("" if self.is_known else " (read from the jumps)")


def wrap_of(values: Array) -> Wrap | None:
    """
    Find the range that a column wraps at; None where it does not.

    It jumps by about its whole range, goes on in the direction that it had, and its steps over the ends are
    no larger than its others: a square wave or a sawtooth that returns to its begin is none.
    """
    span = float(np.ptp(values))
    steps = np.diff(values)
    jumps = np.flatnonzero(np.abs(steps) > 0.5 * span) if span > 0.0 else np.array([], dtype=int)
    others = np.delete(steps, jumps)
    largest = float(np.abs(others).max(initial=0.0))
    if not 0 < len(jumps) < _MOST_JUMPS * len(values) or not 0.0 < largest < 0.25 * span:
        return None
    is_whole = bool(np.all(values == np.round(values)))
    ranges = [2.0**n for n in range(8, 33)] if is_whole else []
    ranges += _ANGLES_OF_INTEGERS if is_whole else _ANGLES
    known = sorted(whole for whole in ranges if whole >= span)
    for whole in (*known, _read_from(steps, jumps)):
        inside = np.min(values) >= -0.5 * whole and np.max(values) <= whole
        if whole >= span and inside and _goes_on(steps, jumps, whole, largest):
            return Wrap(whole, len(jumps), whole in known, _bits(values, whole) if whole in known else None)
    return None


def _read_from(steps: Array, jumps: Integers) -> float:
    """The range by the jumps alone: each with the step that would have been there, by its neighbours."""
    near = [np.median(_around(steps, j, jumps)) for j in jumps]
    return float(np.median(np.abs(steps[jumps] - near)))


def _goes_on(steps: Array, jumps: Integers, whole: float, largest: float) -> bool:
    """Whether the steps over the ends continue the motion, at nearly all of the jumps."""
    fitting = 0
    for j in jumps:
        over = steps[j] - whole * np.sign(steps[j])
        around = _around(steps, j, jumps)
        usual = float(np.mean(around)) if len(around) else 0.0
        continues = over * usual >= 0.0 or abs(over) <= 0.5 * largest
        fitting += bool(abs(over) <= _MOST_OVER * largest and continues and usual * steps[j] <= 0.0)
    return fitting >= _MOST_FITTING * len(jumps)


def _around(steps: Array, j: int, jumps: Integers) -> Array:
    """Steps next to a jump, without other jumps."""
    places = np.arange(max(j - _NEIGHBOURS, 0), min(j + _NEIGHBOURS + 1, len(steps)))
    return np.asarray(steps[np.setdiff1d(places, jumps)])


def _bits(values: Array, whole: float) -> int | None:
    """Bits of two's complement, where nothing lies in the middle half of a range of counts from 0 on."""
    bits = round(math.log2(whole))
    is_counter = 2.0**bits == whole and np.min(values) >= 0.0
    is_middle = (values > 0.25 * whole) & (values < 0.75 * whole)
    return bits if is_counter and not is_middle.any() else None


def _written(whole: float) -> str:
    return f"{whole:.0f}" if whole == round(whole) else f"{whole:.10g}"
