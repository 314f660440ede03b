"""A part of the system over its recordings: inputs as tables, what was measured, where a replay starts."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar
from scipy.signal import decimate

from master.diagnosis.case.case import Case, ReplayEntry
from master.diagnosis.case.cut import Part, Values
from master.diagnosis.data.recordings import Recording
from master.diagnosis.numerics.arrays import Array
from master.text.signal_name import SignalName

from .replayer import Player, ReplayFailure

HEAD, N_GRID = 0.15, 15
Bounds = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Segment:
    """A replay from start values of its own: rows `begin` to `end` of a recording."""

    recording: str
    begin: int
    end: int


class Bench:
    """
    Recordings of one part, one after the other.

    `measured` has shape (rows, outputs); `in_use` is false while a replay settles. Rows are those that are
    compared, after cutting and decimation. `fitted` names the recordings that a fit sees: a start value that
    it gives is theirs, in the others it is estimated.
    """

    def __init__(self, part: Part, recordings: Mapping[str, Recording], case: Case) -> None:
        self.part, self.recordings = part, recordings
        self.options: ReplayEntry = case.replay
        self.period = next(iter(recordings.values())).period
        self.outputs = list(part.compared)
        self.columns = _columns(part)
        self.data = {name: self._table(r) for name, r in recordings.items()}
        windows = [w for fmu, w in self.options.windows.items() if fmu in part.fmus]
        self.is_windowed = bool(windows)
        self.segments = [s for r in recordings.values() for s in _segments(r, windows)]
        self.starts: Bounds = {k: v for k, v in case.starts.items() if SignalName(k).instance in part.fmus}
        self.raw = {n: self._measured(r) for n, r in recordings.items()}
        self.measured = self._joined({n: self.compared(v) for n, v in self.raw.items()})
        self.lengths = {n: len(self.compared(v[:, :1])) for n, v in self.raw.items()}
        self.in_use = self._in_use()
        self.fitted = set(recordings)

    @property
    def row_period(self) -> float:
        """Time between compared rows [s]."""
        return self.period * self.options.decimate

    def begin(self, recording: str) -> int:
        """First row of a recording."""
        names = list(self.lengths)
        return sum(self.lengths[n] for n in names[: names.index(recording)])

    def predict(self, player: Player, values: Values, *, everything: bool = True) -> Array:
        """Replay all, or what a fit sees; shape (rows, outputs), NaN where it failed or was left out."""
        found = self.replayed(player, values, everything=everything)
        return self._joined({n: self.compared(v) for n, v in found.items()})

    def replayed(self, player: Player, values: Values, *, everything: bool = True) -> dict[str, Array]:
        """Outputs at all samples by recording, shape (samples, outputs), before cutting and decimation."""
        places = [player.names.index(name) for name in self.outputs]
        found = {n: np.full(v.shape, np.nan) for n, v in self.raw.items()}
        for s in self.segments if everything else self._fitted_segments():
            rows = self._replay(player, values, s, places)
            found[s.recording][s.begin : s.end] = rows[: s.end - s.begin]
        return found

    def starts_of(self, player: Player) -> list[str]:
        """Start values that a fit can find: it sees one recording, without windows."""
        if self.is_windowed or len(self._fitted_segments()) != 1:
            return []
        return [k for k in self.starts if SignalName(k).variable in _variables(player, k)]

    def estimated(self, player: Player, values: Values) -> dict[str, float]:
        """Estimate those start values on the first part of the recording."""
        places = [player.names.index(name) for name in self.outputs]
        found = self._with_starts(player, values, self._fitted_segments()[0], places)
        return {
            k: float(found[SignalName(k).instance][SignalName(k).variable]) for k in self.starts_of(player)
        }

    def failure(self, player: Player, values: Values) -> ReplayFailure | None:
        """Replay all again and say what is wrong with the first stretch that fails; None if none does."""
        places = [player.names.index(name) for name in self.outputs]
        for s in self.segments:
            self._play(player, self._with_starts(player, values, s, places), s)
            if player.failure is not None:
                return player.failure
        return None

    def record(self, player: Player, values: Values) -> dict[str, Array]:
        """Replay everything and give all signals that the player reads, by name, shape (samples,)."""
        rows = [self._play(player, values, s)[: s.end - s.begin] for s in self.segments]
        return dict(zip(player.names, np.concatenate(rows).T, strict=True))

    def signal(self, name: str) -> Array:
        """A measured signal over all recordings, shape (samples,)."""
        return np.concatenate([r[name] for r in self.recordings.values()])

    def compared_rows(self, values: Array) -> Array:
        """Bring a signal over all samples to the compared rows, shape (rows,)."""
        found, at = [], 0
        for raw in self.raw.values():
            own = values[at : at + len(raw)]
            found.append(own[self.options.cut : len(own) - self.options.cut][:: self.options.decimate])
            at += len(raw)
        return np.concatenate(found)

    def _fitted_segments(self) -> list[Segment]:
        return [s for s in self.segments if s.recording in self.fitted]

    def _replay(self, player: Player, values: Values, s: Segment, places: Sequence[int]) -> Array:
        return np.asarray(self._play(player, self._with_starts(player, values, s, places), s)[:, places])

    def _with_starts(self, player: Player, values: Values, s: Segment, places: Sequence[int]) -> Values:
        """Values with the start values that are to be estimated and are not given."""
        starts = [k for k in self.starts if SignalName(k).variable in _variables(player, k)]
        given = {f"{fmu}.{name}" for fmu, own in values.items() for name in own}
        is_given = s.recording in self.fitted and not self.is_windowed
        starts = [k for k in starts if not (is_given and k in given)]
        if not starts:
            return values
        target = self.raw[s.recording][s.begin : s.end]
        run = _Run(lambda v, n: self._play(player, v, s, n)[:, places], values, target)
        estimate = _by_grid if len(starts) == 1 and not self.is_windowed else _by_steps
        return estimate(run, starts, self.starts)

    def _play(self, player: Player, values: Values, s: Segment, rows: int | None = None) -> Array:
        m = self.options.oversample
        n = (s.end - s.begin - 1 if rows is None else min(rows, s.end - s.begin) - 1) * m
        segment = (s.begin * m, n)
        return player.play(values, self.data[s.recording], segment, self.period / m, m)

    def _table(self, r: Recording) -> Array:
        """Inputs at every step, shape (steps + 1, columns)."""
        m, n = self.options.oversample, len(r)
        places = np.arange((n - 1) * m + 1) / m
        columns = []
        for signal, at in self.columns:
            values = r[signal]
            if at == "start":
                held = values[np.maximum(np.ceil(places).astype(int) - 1, 0)]
                columns.append(held)
            else:
                columns.append(values if m == 1 else CubicSpline(np.arange(n), values)(places))
        return np.ascontiguousarray(np.column_stack(columns or [np.zeros(len(places))]))

    def _measured(self, r: Recording) -> Array:
        return np.column_stack([r[self.part.compared[name]] for name in self.outputs])

    def compared(self, values: Array) -> Array:
        """Cut and decimate what stands at all samples, shape (samples, n)."""
        cut, every = self.options.cut, self.options.decimate
        values = values[cut : len(values) - cut] if cut else values
        if every == 1:
            return values
        if not np.isfinite(values).all():
            return np.full((len(values[::every]), values.shape[1]), np.nan)
        return np.asarray(decimate(values, every, axis=0, zero_phase=True))

    def _joined(self, values: Mapping[str, Array]) -> Array:
        return np.concatenate([values[name] for name in self.recordings])

    def _in_use(self) -> NDArray[np.bool_]:
        settle = round(self.options.settle / self.period)
        used = {name: np.ones(len(r)) for name, r in self.recordings.items()}
        for s in self.segments:
            used[s.recording][s.begin : s.begin + settle] = 0.0
        joined = np.concatenate([used[name] for name in self.recordings])
        return np.asarray(self.compared_rows(joined) > 0.0)


@dataclass(frozen=True)
class _Run:
    """Replays of one segment with other start values, against what was measured."""

    play: Callable[[Values, int], Array]
    values: Values
    target: Array

    def residual(self, starts: Mapping[str, float], n: int) -> Array:
        n = min(n, len(self.target))
        left = self.play(self.with_starts(starts), n)[:n] - self.target[:n]
        size = self.target.std(axis=0)
        return np.asarray((left / np.where(size > 0.0, size, 1.0)).ravel())

    def with_starts(self, starts: Mapping[str, float]) -> Values:
        values = {name: dict(v) for name, v in self.values.items()}
        for key, value in starts.items():
            name, variable = SignalName(key).parts
            values[name][variable] = value
        return values


def _by_grid(run: _Run, names: Sequence[str], bounds: Bounds) -> Values:
    """Estimate one start value on the first part of a recording."""
    (low, high), n = bounds[names[0]], max(2, round(HEAD * len(run.target)))

    def cost(value: float) -> float:
        left = run.residual({names[0]: float(value)}, n)
        return float(left @ left) if np.isfinite(left).all() else np.inf

    grid = np.linspace(low, high, N_GRID)
    best = int(np.argmin([cost(v) for v in grid]))
    around = (float(grid[max(0, best - 1)]), float(grid[min(N_GRID - 1, best + 1)]))
    found = minimize_scalar(cost, bounds=around, method="bounded", options={"xatol": 1e-5 * (high - low)})
    return run.with_starts({names[0]: float(found.x)})


def _by_steps(run: _Run, names: Sequence[str], bounds: Bounds) -> Values:
    """Estimate start values on a whole segment by two Gauss-Newton steps."""
    x = np.array([0.5 * sum(bounds[name]) for name in names])
    steps = np.array([1e-3 * (bounds[name][1] - bounds[name][0]) for name in names])
    n = len(run.target)
    for _ in range(2):
        base = run.residual(dict(zip(names, x, strict=True)), n)
        columns = []
        for i, step in enumerate(steps):
            moved = x.copy()
            moved[i] += step
            columns.append((run.residual(dict(zip(names, moved, strict=True)), n) - base) / step)
        matrix = np.column_stack(columns)
        if not (np.isfinite(matrix).all() and np.isfinite(base).all()):
            break
        x = x - np.linalg.lstsq(matrix, base, rcond=None)[0]
    return run.with_starts(dict(zip(names, x.tolist(), strict=True)))


def _variables(player: Player, key: str) -> Mapping[str, object]:
    name = SignalName(key).instance
    return next((link.description.by_name for link in player.chain if link.name == name), {})


def _columns(part: Part) -> list[tuple[str, str]]:
    return list(dict.fromkeys(c for inputs in part.inputs.values() for c in inputs.values()))


def _segments(r: Recording, windows: Sequence[float]) -> list[Segment]:
    n = len(r)
    length = n if not windows else max(2, round(min(windows) / r.period))
    edges = [*range(0, n - length // 2, length), n]
    return [Segment(r.name, a, b) for a, b in itertools.pairwise(edges)]
