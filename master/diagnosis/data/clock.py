"""
The clock of a recording: even as it is, printed short, or with gaps and jitter that a case lets pass.

A clock that is printed with few digits repeats and jumps, though the rows are even: then every time lies
within one step of its print of a straight line, and the period follows from the ends. Nothing else is
straightened.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from master.diagnosis.numerics.arrays import Array, Mask
from master.recording.tables import shortened

JITTER = 0.05  # of a step, by which it may differ from the usual one
GAP = 1.5  # of the usual step: a longer one is a gap
GAP_OF_JITTER = 2.5  # the same where rows are resampled, for steps that differ
CLOCK_TOLERANCE = 1e-3  # of the sampling period, by which the mean step may differ
MOST_DIGITS = 9  # of a print that is called short
LEAST_UNEVEN = 0.02  # share of steps: a short print shows in more of them, a lost row in fewer
WITHIN = 1.02  # steps of the print, by which a time may differ from the straight line
EXACT = 1e-9  # of a step of the print
N_ROUNDS = 8


@dataclass(frozen=True)
class ClockRules:
    """
    What a clock must keep, times in s.

    `period` is what it should say (None: not known), `start` the time of its first row, `jitter` the share
    of the usual step that is let pass. `splits` allows gaps, longer than `gap` or `GAP` usual steps;
    `resampled` allows steps that differ. `hints` adds what a case may write.
    """

    period: float | None = None
    start: float | None = 0.0
    jitter: float = JITTER
    splits: bool = False
    resampled: bool = False
    gap: float | None = None
    hints: bool = False


@dataclass(frozen=True)
class Clock:
    """
    Times t [s] of the rows, shape (n,), cut into `pieces` (begin, end) at gaps.

    `period` [s] is the mean step, `notes` say what was done to how many rows, `problems` what is wrong.
    """

    t: Array
    pieces: tuple[tuple[int, int], ...]
    period: float
    notes: tuple[str, ...] = ()
    problems: tuple[str, ...] = ()


def clock_of(t: Array, printed: Array | None, rules: ClockRules, where: str, first_row: int) -> Clock:
    """
    Look at the times of the rows.

    Args:
        t: Times [s], finite, shape (n,), n > 2.
        printed: Step of the print at each of them [s], None where they are not printed short.
        rules: What the clock must keep.
        where: File, for what is wrong.
        first_row: Number that people see for row 0.
    """
    if printed is not None and is_uneven(t, rules.jitter):
        straight = straightened(t, printed)
        if straight is not None and (rules.splits or rules.resampled or len(straight.pieces) == 1):
            problems = _wrong(straight, rules, where)
            note = (
                f"clock: printed in steps of up to {printed.max():.6g} s, {len(t)} times replaced by even "
                f"ones; period {straight.period:.9g} s from the ends"
            )
            return replace(straight, notes=(note, *_gaps_told(straight)), problems=tuple(problems))
    steps = np.diff(t)
    usual = float(np.median(np.abs(steps)))
    gap = rules.gap or usual * (GAP_OF_JITTER if rules.resampled else GAP)
    is_gap = steps > gap if rules.splits or rules.resampled else np.zeros(len(steps), dtype=bool)
    clock = Clock(t, _pieces(is_gap), float(steps[~is_gap].mean()) if not is_gap.all() else usual)
    back = [
        f"{where}: row {i + 1 + first_row}: time goes from {t[i]:.9g} to {t[i + 1]:.9g} s, "
        "expected it to grow"
        for i in np.flatnonzero(steps <= 0.0)
    ]
    problems = [
        *shortened(back, "steps back"),
        *_step_faults(t, steps, is_gap, rules, where, first_row),
        *_wrong(clock, rules, where),
    ]
    return replace(clock, notes=tuple(_gaps_told(clock)), problems=tuple(problems))


def printed_steps(values: Array) -> list[Array]:
    """
    Steps in which numbers may be printed, one for each value, the coarsest first.

    Tried are fixed decimals, a number of digits, and single precision.
    """
    found = []
    for digits in range(MOST_DIGITS):
        step = 10.0**-digits
        if _are_multiples(values, np.full(len(values), step)):
            found.append(np.full(len(values), step))
            break
    size = np.abs(values)
    least = float(size[size > 0.0].min(initial=math.inf))
    if math.isfinite(least):
        powers = np.floor(np.log10(np.maximum(size, least)) + EXACT)
        for digits in range(2, MOST_DIGITS):
            steps: Array = 10.0 ** (powers + 1 - digits)
            if _are_multiples(values, steps):
                found.append(steps)
                break
    single = values.astype(np.float32)
    if np.array_equal(single.astype(np.float64), values):
        found.append(np.spacing(np.abs(single)).astype(np.float64))
    return found


def coarsest_print(values: Array) -> Array | None:
    """Steps of the print that explain most of how uneven times are; None where the values have all digits."""
    found = printed_steps(values)
    if not found:
        return None
    for steps in found:
        if straightened(values, steps) is not None:
            return steps
    return found[0]


def straightened(t: Array, printed: Array) -> Clock | None:
    """Times on a straight line between gaps, if that is what was printed; else None."""
    steps = np.diff(t)
    coarse = np.maximum(printed[1:], printed[:-1])
    if np.any(steps < -EXACT * coarse):
        return None
    period = float((t[-1] - t[0]) / len(steps))
    for _ in range(N_ROUNDS):
        is_gap = steps > GAP * period + 2.0 * coarse
        if is_gap.all():
            return None
        shorter = float(steps[~is_gap].mean())
        if shorter == period:
            break
        period = shorter
    pieces = _pieces(is_gap)
    line = _line(t, 1.0 / printed, pieces)
    if line is None:
        return None
    fitted, period = line
    within = np.abs(t - fitted) <= WITHIN * printed
    return Clock(fitted, pieces, period) if period > 0.0 and within.all() else None


def _line(t: Array, weights: Array, pieces: Sequence[tuple[int, int]]) -> tuple[Array, float] | None:
    """Fit one slope and an offset for each piece; None where no piece has two rows."""
    rows = np.arange(len(t), dtype=np.float64)
    power = weights**2
    above = 0.0
    below = 0.0
    centres = []
    for begin, end in pieces:
        own = power[begin:end]
        row = float(own @ rows[begin:end] / own.sum())
        time = float(own @ t[begin:end] / own.sum())
        centres.append((row, time))
        above += float(own * (rows[begin:end] - row) @ (t[begin:end] - time))
        below += float(own @ (rows[begin:end] - row) ** 2)
    if below <= 0.0:
        return None
    slope = above / below
    fitted = np.empty(len(t))
    for (begin, end), (row, time) in zip(pieces, centres, strict=True):
        fitted[begin:end] = time + slope * (rows[begin:end] - row)
    return fitted, slope


def _pieces(is_gap: Mask) -> tuple[tuple[int, int], ...]:
    edges = [0, *(np.flatnonzero(is_gap) + 1).tolist(), len(is_gap) + 1]
    return tuple(itertools.pairwise(edges))


def is_uneven(t: Array, jitter: float) -> bool:
    """Whether more steps than a few lost rows differ from the usual one."""
    steps = np.diff(t)
    usual = float(np.median(steps))
    return bool(np.mean(np.abs(steps - usual) > jitter * usual) > LEAST_UNEVEN)


def _are_multiples(values: Array, steps: Array) -> bool:
    ratio = values / steps
    return bool(np.all(np.abs(ratio - np.round(ratio)) <= EXACT * np.maximum(1.0, np.abs(ratio))))


def _gaps_told(clock: Clock) -> list[str]:
    if len(clock.pieces) == 1:
        return []
    lost = [
        clock.t[later[0]] - clock.t[earlier[1] - 1] for earlier, later in itertools.pairwise(clock.pieces)
    ]
    return [
        f"gaps: {len(lost)}, the longest of {max(lost):.6g} s; cut there into {len(clock.pieces)} pieces, "
        "each replayed from start values of its own"
    ]


def _step_faults(
    t: Array, steps: Array, is_cut: Mask, rules: ClockRules, where: str, first_row: int
) -> list[str]:
    usual = float(np.median(np.abs(steps)))
    is_back = steps <= 0.0
    is_known = is_cut | is_back | np.concatenate([[False], is_back[:-1]])  # and what makes up for a step back
    is_gap = (steps > GAP * usual) & ~is_known
    is_jitter = (np.abs(steps - usual) > rules.jitter * usual) & ~is_gap & ~is_known
    if rules.resampled:
        return []
    problems: list[str] = []
    kinds = (
        (is_gap, "gap", "time.gaps: split cuts there"),
        (is_jitter, "jitter", "resample: {method: linear} makes rows even"),
    )
    for chosen, what, help_ in kinds:
        faults = [
            f"{where}: row {i + 1 + first_row}: {what}, got a step of {steps[i]:.6g} s after "
            f"t={t[i]:.9g} s, expected {usual:.6g} s"
            for i in np.flatnonzero(chosen)
        ]
        if faults and rules.hints:
            faults[0] += f" ({help_})"
        problems += shortened(faults, f"rows with {what}")
    return problems


def _wrong(clock: Clock, rules: ClockRules, where: str) -> list[str]:
    problems = []
    first = float(clock.t[0])
    if rules.start is not None and abs(first - rules.start) > 0.5 * clock.period:
        problems.append(
            f"{where}: clock offset, got a first time of {first:.9g} s, expected {rules.start:.9g} s "
            "(give the time column an offset)"
        )
    wanted = None if rules.resampled else rules.period
    if wanted is not None and abs(clock.period / wanted - 1.0) > CLOCK_TOLERANCE:
        problems.append(f"{where}: sampling period, got {clock.period:.9g} s, expected {wanted:.9g} s")
    return problems
