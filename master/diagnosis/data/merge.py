"""
Signals of a second logger on the rows of the first, each with its own clock.

An event at t on the first clock is stamped t + delay on the second. The delay is given, or found where one
is best told from the other: by a quantity that both have recorded, or by the linear relation of what is
compared to what drives.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
import scipy  # loads its packages when they are used

from master.diagnosis.numerics.arrays import Array, Mask
from master.diagnosis.numerics.noise_floor import noise_floor
from master.errors import DataError

from .recordings import FEWEST_OF_PIECE, Rows

N_GRID = 41  # delays tried between the bounds, before the best is refined
TOLERANCE = 1e-4  # of the distance of the bounds
PASSED = 0.15  # of the slower sampling rate: interpolation makes faster noise smaller between rows
MOST_ROWS = 20_000  # that an estimate looks at
AT_BOUND = 0.02  # of the distance of the bounds
EDGES = (0.003, 0.01, 0.03, 0.1)  # of the largest rate: where dry friction may have changed its sign
LEAST_FALL = 0.02  # of what is left at the worst delay: less tells no delay
LEAST_KNOWN = 0.25  # of the distance of the bounds
MARGIN = 3.0  # periods of the slowest oscillation that is left out, at the ends of a piece
HELP = "name a quantity that both recorded (shared), or give the delay"
MOST_PULLED = 3.0  # deviations that a delay may move with as much noise again
N_DRAWS = 2  # of noise
LONGEST_MEMORY = 0.1  # of the rows, over which residuals may be alike


@dataclass(frozen=True)
class Delay:
    """A delay [s] and its standard deviation [s]; `source` says what it was read from."""

    value: float
    deviation: float
    source: str

    def __str__(self) -> str:
        if not self.deviation:
            return f"{self.value:.6g} s ({self.source})"
        return f"{self.value:.6g} +- {self.deviation:.2g} s ({self.source})"


@dataclass(frozen=True)
class Sought:
    """Bounds of a delay [s] that is to be found."""

    low: float
    high: float


Made = Callable[[Mapping[str, Array], float], Mapping[str, Array]]


def merged(first: Rows, second: Rows, delay: Delay) -> Rows:
    """
    Take the signals of a second logger to the rows of the first by cubic splines.

    Rows that the second has not, before its begin, after its end or in a gap of it, are left out.

    Raises:
        DataError: If no row is left.
    """
    at = first.t + delay.value
    signals: dict[str, Array] = {name: np.full(len(at), np.nan) for name in second.signals}
    piece_of = np.full(len(at), -1)
    for i, (begin, end) in enumerate(second.pieces):
        if end - begin < FEWEST_OF_PIECE:
            continue
        t = second.t[begin:end]
        own = (at >= t[0]) & (at <= t[-1])
        piece_of[own] = i
        for name, values in second.signals.items():
            signals[name][own] = scipy.interpolate.CubicSpline(t, values[begin:end])(at[own])
    kept = piece_of >= 0
    if not kept.any():
        raise DataError(
            f"merge: no row in common, got {first.t[0]:.6g} to {first.t[-1]:.6g} s and, with the delay, "
            f"{second.t[0] - delay.value:.6g} to {second.t[-1] - delay.value:.6g} s, "
            "expected clocks that overlap"
        )
    note = (
        f"merged: {', '.join(second.signals)} of the second logger, {len(second.t)} rows every "
        f"{second.period:.6g} s, on {int(kept.sum())} rows of the first, delay {delay}; "
        f"{int(np.sum(~kept))} rows without it left out"
    )
    all_signals = {**first.signals, **signals}
    return Rows(
        t=first.t[kept],
        pieces=_pieces(first.pieces, piece_of, kept),
        period=first.period,
        signals={name: values[kept] for name, values in all_signals.items()},
        notes=(*first.notes, *(f"second logger: {n}" for n in second.notes), note),
    )


def by_shared(first: Rows, second: Rows, pairs: Mapping[str, str], sought: Sought) -> Delay:
    """
    Find the delay by quantities that both have recorded: name in the first to name in the second.

    Raises:
        DataError: If it is not found between its bounds.
    """
    taken = _Taken(second, tuple(pairs.values()))

    def related(delay: float, rows: slice) -> Related:
        one = np.column_stack([first.signals[name][rows] for name in pairs])
        return Related(one, taken(first.t[rows] + delay))

    is_open = np.ones(len(first.t), dtype=bool)
    return _Estimate(first, second, sought, related, is_open).found("by what both recorded")


def by_relation(
    first: Rows,
    second: Rows,
    made: Made,
    *,
    drivers: Sequence[str],
    rates: Sequence[str],
    compared: Sequence[str],
    open_rows: Mask,
    sought: Sought,
) -> Delay:
    """
    Find the delay by how well what is compared follows what drives, linearly and with dry friction.

    Args:
        first: Rows of the first logger.
        second: Those of the second.
        made: Signals of the case from columns on rows of the first and their period.
        drivers: Signals that drive.
        rates: Those of them that are speeds: dry friction follows their sign.
        compared: Signals that follow.
        open_rows: Rows of the first that may be looked at.
        sought: Bounds of the delay.

    Raises:
        DataError: If it is not found between its bounds.
    """
    taken = _Taken(second, tuple(second.signals))

    def related(delay: float, rows: slice, of: Rows = first) -> Related:
        shifted = taken(of.t[rows] + delay)
        columns = {name: values[rows] for name, values in of.signals.items()}
        columns |= {name: shifted[:, i] for i, name in enumerate(second.signals)}
        signals = made(columns, first.period)
        speeds = [v for v in (signals[name] for name in rates) if np.abs(v).max() > 0.0]
        edges = [np.tanh(v / (edge * np.abs(v).max())) for v in speeds for edge in EDGES]
        basis = [*(signals[name] for name in drivers), *edges]
        return Related(np.column_stack([signals[name] for name in compared]), np.column_stack(basis))

    source = "by how what is compared follows what drives"
    found = _Estimate(first, second, sought, related, open_rows).found(source)
    pulled = _pulled(related, first, second, open_rows, sought)
    if abs(pulled - found.value) > max(MOST_PULLED * found.deviation, 0.5 * max(first.period, second.period)):
        raise DataError(
            f"merge.delay: got {found.value:.6g} s, and {pulled:.6g} s with as much noise again on what the "
            f"first recorded: a delay looks like the rest of the relation here: {HELP}"
        )
    return replace(found, deviation=max(found.deviation, abs(pulled - found.value)))


def _pulled(
    related: Callable[..., Related], first: Rows, second: Rows, open_rows: Mask, sought: Sought
) -> float:
    """
    The delay [s] with twice the power of the noise on the columns of the first logger, over some draws.

    Noise on what drives makes its coefficients too small, and what looks like them, a delay too, makes up for
    it: by about as much as the delay moves here.
    """
    floors = {
        name: noise_floor([v], [np.empty((len(v), 0))], first.period) for name, v in first.signals.items()
    }
    found = []
    for seed in range(N_DRAWS):
        rng = np.random.default_rng(seed)
        noisy = {n: v + floors[n].value * rng.standard_normal(len(v)) for n, v in first.signals.items()}
        own = replace(first, signals=noisy)
        estimate = _Estimate(own, second, sought, partial(related, of=own), open_rows)
        found.append(estimate.best())
    return float(np.mean(found))


class Related(NamedTuple):
    """What is to be made, shape (n, targets), of what by least squares, shape (n, basis)."""

    target: Array
    basis: Array


class _Taken:
    """Signals of rows at other times, shape (n, names)."""

    def __init__(self, rows: Rows, names: Sequence[str]) -> None:
        self._splines = [scipy.interpolate.CubicSpline(rows.t, rows.signals[name]) for name in names]

    def __call__(self, at: Array) -> Array:
        return np.column_stack([spline(at) for spline in self._splines])


class _Estimate:
    """Search of the delay that leaves least of one quantity when it is made from another."""

    def __init__(
        self,
        first: Rows,
        second: Rows,
        sought: Sought,
        related: Callable[[float, slice], Related],
        open_rows: Mask,
    ) -> None:
        self._sought = sought
        self._related = related
        passed = PASSED * min(1.0, first.period / second.period)
        self._low_pass = scipy.signal.butter(2, 2.0 * passed, output="sos")
        margin = round(MARGIN / passed)
        is_common = _is_common(first, second, sought)
        self._pieces = []
        counted = []
        for begin, end in _common_pieces(first, is_common):
            own = open_rows[begin:end].copy()
            own[:margin] = False
            own[len(own) - margin :] = False
            if own.any():
                self._pieces.append(slice(begin, end))
                counted.append(own)
        n = sum(int(own.sum()) for own in counted)
        if n < FEWEST_OF_PIECE:
            raise DataError(
                f"merge.delay: got {n} rows that both have for every delay from {sought.low:g} to "
                f"{sought.high:g} s, expected {FEWEST_OF_PIECE} or more"
            )
        every = max(1, n // MOST_ROWS)
        self._counted = [np.flatnonzero(own)[::every] for own in counted]
        ends = [self._filtered(delay).basis for delay in (sought.low, sought.high)]
        self._fixed = np.linalg.qr(ends[0])[0] if np.array_equal(ends[0], ends[1]) else None

    def best(self) -> float:
        """The delay [s] that leaves least between the bounds, whatever it is worth."""
        grid = np.linspace(self._sought.low, self._sought.high, N_GRID)
        at = int(np.argmin([self._cost(float(d)) for d in grid]))
        around = (float(grid[max(0, at - 1)]), float(grid[min(N_GRID - 1, at + 1)]))
        tolerance = TOLERANCE * (self._sought.high - self._sought.low)
        found = scipy.optimize.minimize_scalar(
            self._cost, bounds=around, method="bounded", options={"xatol": tolerance}
        )
        return float(found.x)

    def found(self, source: str) -> Delay:
        """The delay and its deviation; raises DataError where the rows do not tell it."""
        low = self._sought.low
        high = self._sought.high
        width = high - low
        grid = np.linspace(low, high, N_GRID)
        costs = np.array([self._cost(float(d)) for d in grid])
        best = int(np.argmin(costs))
        around = (float(grid[max(0, best - 1)]), float(grid[min(N_GRID - 1, best + 1)]))
        refined = scipy.optimize.minimize_scalar(
            self._cost, bounds=around, method="bounded", options={"xatol": TOLERANCE * width}
        )
        value = float(refined.x)
        least = float(refined.fun)
        if min(value - low, high - value) < AT_BOUND * width:
            raise DataError(
                f"merge.delay: got the best at its bound ({value:.6g} s of {low:g} to {high:g} s), "
                "expected one between: widen the bounds, or give the delay"
            )
        fall = 1.0 - least / costs.max()
        if fall < LEAST_FALL:
            raise DataError(
                f"merge.delay: got {100 * fall:.2g} % less left at the best than at the worst, "
                f"expected a relation that tells the delay: {HELP}"
            )
        step = max(0.25 * float(grid[1] - grid[0]), 4.0 * TOLERANCE * width)
        bend = (self._cost(value + step) - 2.0 * least + self._cost(value - step)) / step**2
        residual = self._left(value)
        n = residual.size / _memory(residual)
        deviation = float(np.sqrt(2.0 * least / (n * bend))) if bend > 0.0 else width
        if deviation > LEAST_KNOWN * width:
            raise DataError(
                f"merge.delay: got {value:.6g} +- {deviation:.2g} s, expected it known better than a quarter "
                f"of its bounds: {HELP}"
            )
        return Delay(value, deviation, source)

    def _cost(self, delay: float) -> float:
        return float(np.mean(self._left(delay) ** 2))

    def _left(self, delay: float) -> Array:
        found = self._filtered(delay)
        if self._fixed is not None:
            return np.asarray(found.target - self._fixed @ (self._fixed.T @ found.target))
        return np.asarray(
            found.target - found.basis @ np.linalg.lstsq(found.basis, found.target, rcond=None)[0]
        )

    def _filtered(self, delay: float) -> Related:
        """Both at a delay, of the rows that count, without mean and of size 1."""
        parts = [self._related(delay, rows) for rows in self._pieces]
        sides = []
        for side in zip(*parts, strict=True):
            kept = [
                scipy.signal.sosfiltfilt(self._low_pass, values, axis=0)[own]
                for values, own in zip(side, self._counted, strict=True)
            ]
            joined = np.concatenate(kept)
            joined = joined - joined.mean(axis=0)
            size = joined.std(axis=0)
            sides.append(joined / np.where(size > 0.0, size, 1.0))
        return Related(*sides)


def _is_common(first: Rows, second: Rows, sought: Sought) -> Mask:
    """Rows of the first that the second has for every delay, outside its gaps."""
    is_common = np.zeros(len(first.t), dtype=bool)
    for begin, end in second.pieces:
        t = second.t[begin:end]
        is_common |= (first.t + sought.low >= t[0]) & (first.t + sought.high <= t[-1])
    return is_common


def _common_pieces(first: Rows, is_common: Mask) -> Iterator[tuple[int, int]]:
    """Stretches of rows without a gap that are common and long enough to be filtered."""
    for begin, end in first.pieces:
        edges = np.flatnonzero(np.diff(is_common[begin:end].astype(int), prepend=0, append=0)) + begin
        yield from ((a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= FEWEST_OF_PIECE)


def _memory(residual: Array) -> float:
    """Rows that count as one, since they are alike."""
    longest = max(1, int(LONGEST_MEMORY * len(residual)))
    total = 1.0
    for column in residual.T:
        centred = column - column.mean()
        power = float(centred @ centred)
        if power <= 0.0:
            continue
        spectrum = np.abs(np.fft.rfft(centred, 2 * len(centred))) ** 2
        likeness = np.fft.irfft(spectrum)[1 : longest + 1] / power
        negative = np.flatnonzero(likeness <= 0.0)
        total = max(total, 1.0 + 2.0 * float(likeness[: negative[0] if len(negative) else None].sum()))
    return total


def _pieces(pieces: Sequence[tuple[int, int]], piece_of: Array, kept: Mask) -> tuple[tuple[int, int], ...]:
    """Pieces of the rows that are kept: cut where either logger has a gap, or rows between are left out."""
    own = np.repeat(np.arange(len(pieces)), [end - begin for begin, end in pieces])
    places = np.flatnonzero(kept)
    is_cut = (np.diff(own[places]) != 0) | (np.diff(piece_of[places]) != 0) | (np.diff(places) > 1)
    edges = [0, *(np.flatnonzero(is_cut) + 1).tolist(), len(places)]
    return tuple(itertools.pairwise(edges))


def without(rows: Rows, names: Sequence[str]) -> Rows:
    """The same rows without some signals."""
    return replace(rows, signals={name: v for name, v in rows.signals.items() if name not in names})
