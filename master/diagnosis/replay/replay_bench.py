"""A part of the system over its recordings: inputs as tables, what was measured, where a replay starts."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Mapping, Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import decimate

from master.diagnosis.case.case import Case, ReplayEntry
from master.diagnosis.case.cut import CutPart, Values
from master.diagnosis.data.recordings import Recording
from master.diagnosis.numerics.arrays import Array, Mask
from master.text.signal_name import SignalName

from .own_values import not_fitted, of_recording
from .replayer import Player, ReplayFailure
from .start_values import Bounds, StartEstimate, by_fit, by_grid, by_steps, head


@dataclass(frozen=True)
class Segment:
    """A replay from start values of its own: rows `begin` to `end` (not included) of a recording."""

    recording: str
    begin: int
    end: int

    def __len__(self) -> int:
        return self.end - self.begin


@dataclass(frozen=True)
class Estimated:
    """Values `fmu.variable` that were estimated on the first `rows` samples of a segment."""

    names: tuple[str, ...]
    rows: int


class ReplayBench:
    """
    Recordings of one part, one after the other.

    Samples are those of the recordings, rows those that are compared, after cutting and decimation.
    `measured` has shape (rows, outputs); `in_use` is false while a replay settles. `fitted` names the
    recordings that a fit sees (all if None): a start value that it gives is theirs, in the others it is
    estimated.
    """

    def __init__(
        self,
        part: CutPart,
        recordings: Mapping[str, Recording],
        case: Case,
        fitted: Collection[str] | None = None,
    ) -> None:
        self.part = part
        self.recordings = recordings
        self.options: ReplayEntry = case.replay
        self.fitted = set(recordings if fitted is None else fitted)
        self.period = next(iter(recordings.values())).period
        self.outputs = list(part.compared)
        self.starts: Bounds = {k: v for k, v in case.starts.items() if SignalName(k).instance in part.fmus}
        self.own: Bounds = {
            key: (case.refit[key].low, case.refit[key].high)
            for key in case.per_recording
            if SignalName(key).instance in part.fmus
        }
        windows = [w for fmu, w in self.options.windows.items() if fmu in part.fmus]
        self.is_windowed = bool(windows)
        self.segments = [s for r in recordings.values() for s in _segments(r, windows)]
        self.data = {name: self._table(r) for name, r in recordings.items()}
        self.raw = {name: self._measured(r) for name, r in recordings.items()}
        compared = {name: self.compared(values) for name, values in self.raw.items()}
        self.lengths = {name: len(values) for name, values in compared.items()}
        self.measured = self._joined(compared)
        self.in_use = self._in_use()
        self.estimates: dict[Segment, Estimated] = {}
        self._inverses: dict[tuple[Player, Segment, int], Array | None] = {}

    @property
    def name(self) -> str:
        """Name of the part."""
        return self.part.name

    @property
    def row_period(self) -> float:
        """Time between compared rows [s]."""
        return self.period * self.options.decimate

    @property
    def times(self) -> Array:
        """Time in its replay of every sample of all recordings [s], shape (samples,)."""
        return np.concatenate([np.arange(len(r)) * self.period for r in self.recordings.values()])

    def first_sample(self, recording: str) -> int:
        """First sample of a recording among those of all."""
        names = list(self.recordings)
        return sum(len(self.recordings[n]) for n in names[: names.index(recording)])

    def begin(self, recording: str) -> int:
        """First row of a recording among those of all."""
        names = list(self.lengths)
        return sum(self.lengths[n] for n in names[: names.index(recording)])

    def predict(self, player: Player, values: Values, *, everything: bool = True) -> Array:
        """Replay all, or what a fit sees; shape (rows, outputs), NaN where it failed or was left out."""
        outputs = self.replayed(player, values, everything=everything)
        return self._joined({name: self.compared(v) for name, v in outputs.items()})

    def replayed(self, player: Player, values: Values, *, everything: bool = True) -> dict[str, Array]:
        """Outputs at all samples by recording, shape (samples, outputs), before cutting and decimation."""
        places = self._places(player)
        outputs = {name: np.full(v.shape, np.nan) for name, v in self.raw.items()}
        for s in self.segments if everything else self._fitted_segments():
            played = self._play(player, self._with_starts(player, values, s), s)
            outputs[s.recording][s.begin : s.end] = played[: len(s), places]
        return outputs

    def values_in(self, values: Values, recording: str) -> Values:
        """Values that hold in one recording: with those that it has for itself."""
        r = self.recordings[recording]
        return of_recording(values, r.entry or recording, r.given)

    def afresh(self) -> ReplayBench:
        """Return the same with nothing estimated yet; `estimates` then holds what its own replays look at."""
        other = copy(self)
        other.estimates = {}
        return other

    def looked_at(self) -> Mask:
        """
        Rows, shape (rows,), on which values of their recording were estimated: they prove nothing.

        In windows those are all rows; these are not marked, each window being a short replay of its own.
        """
        seen = {name: np.zeros(len(r)) for name, r in self.recordings.items()}
        for s, own in self.estimates.items():
            if own.rows < len(s):
                seen[s.recording][s.begin : s.begin + own.rows] = 1.0
        return np.asarray(self.compared_rows(self._joined(seen)) > 0.0)

    def with_inputs(self, change: Callable[[Array], Array]) -> ReplayBench:
        """Return the same with other inputs: `change` takes and returns a table (steps + 1, columns)."""
        other = copy(self)
        other.data = {name: np.ascontiguousarray(change(table)) for name, table in self.data.items()}
        return other

    def with_noise(self, deviations: Sequence[float], seed: int) -> ReplayBench:
        """Return the same with white noise on the measured inputs, one deviation a column."""
        rng = np.random.default_rng(seed)
        return self.with_inputs(
            lambda table: table + rng.standard_normal(table.shape) * np.asarray(deviations)
        )

    def starts_of(self, player: Player) -> list[str]:
        """Start values that a fit can find: it sees one recording, without windows."""
        if self.is_windowed or len(self._fitted_segments()) != 1:
            return []
        return self._known_starts(player)

    def estimated(self, player: Player, values: Values) -> dict[str, float]:
        """Estimate those start values, by `fmu.variable`: first guesses of a fit, several on all samples."""
        starts = self.starts_of(player)
        given = self._with_starts(player, values, self._fitted_segments()[0], as_guess=True)
        return {key: float(given[SignalName(key).instance][SignalName(key).variable]) for key in starts}

    def failure(self, player: Player, values: Values) -> ReplayFailure | None:
        """Replay all again and say what is wrong with the first segment that fails; None if none does."""
        for s in self.segments:
            self._play(player, self._with_starts(player, values, s), s)
            if player.failure is not None:
                return player.failure
        return None

    def record(self, player: Player, values: Values) -> dict[str, Array]:
        """Replay everything and return all signals that the player reads, by name, shape (samples,)."""
        played = [self._play(player, values, s)[: len(s)] for s in self.segments]
        return dict(zip(player.names, np.concatenate(played).T, strict=True))

    def signal(self, name: str) -> Array:
        """A measured signal over all recordings, shape (samples,)."""
        return np.concatenate([r[name] for r in self.recordings.values()])

    def compared_rows(self, values: Array) -> Array:
        """Pick from a signal over all samples the compared rows, unfiltered, shape (rows,)."""
        cut = self.options.cut
        rows = []
        for recording in self.recordings:
            first = self.first_sample(recording)
            own = values[first : first + len(self.recordings[recording])]
            rows.append(own[cut : len(own) - cut][:: self.options.decimate])
        return np.concatenate(rows)

    def compared(self, values: Array) -> Array:
        """Cut and decimate signals at all samples of a recording, shape (samples, n) to (rows, n)."""
        cut = self.options.cut
        every = self.options.decimate
        values = values[cut : len(values) - cut] if cut else values
        if every == 1:
            return values
        if not np.isfinite(values).all():
            return np.full((len(values[::every]), values.shape[1]), np.nan)
        return np.asarray(decimate(values, every, axis=0, zero_phase=True))

    def _places(self, player: Player) -> list[int]:
        """Columns of the compared outputs in what a player returns."""
        return [player.names.index(name) for name in self.outputs]

    def _fitted_segments(self) -> list[Segment]:
        return [s for s in self.segments if s.recording in self.fitted]

    def _known_starts(self, player: Player) -> list[str]:
        """Start values of the case that belong to variables of the player's FMUs."""
        variables = {link.name: link.description.by_name for link in player.chain}
        starts = [SignalName(key) for key in self.starts]
        return [s for s in starts if s.variable in variables.get(s.instance, {})]

    def _with_starts(self, player: Player, values: Values, s: Segment, *, as_guess: bool = False) -> Values:
        """Values with the start values that are to be estimated and are not given."""
        r = self.recordings[s.recording]
        own = [key for key in not_fitted(values, self.own, r.entry or s.recording) if key not in r.given]
        if own:
            first = StartEstimate(
                play=lambda v, n: self._play(player, v, s, n)[:, self._places(player)],
                values=values,
                target=self.raw[s.recording][s.begin : s.end],
            )
            values = by_fit(first, {key: self.own[key] for key in own})
            self._note(s, own, head(len(s)))
        given = {f"{fmu}.{name}" for fmu, own in values.items() for name in own}
        is_given = s.recording in self.fitted and not self.is_windowed
        names = [k for k in self._known_starts(player) if not (is_given and k in given)]
        if not names:
            return values
        places = self._places(player)
        estimate = StartEstimate(
            play=lambda v, n: self._play(player, v, s, n)[:, places],
            values=values,
            target=self.raw[s.recording][s.begin : s.end],
        )
        is_fitted = as_guess or s.recording in self.fitted
        rows = len(s) if self.is_windowed or is_fitted else head(len(s))
        if self.is_windowed or not is_fitted:
            self._note(s, names, rows)
        if len(names) == 1 and not self.is_windowed:
            return by_grid(estimate, names[0], self.starts[names[0]])
        key = (player, s, rows)
        bounds = {name: self.starts[name] for name in names}
        found = by_steps(estimate, bounds, rows, self._inverses.get(key))
        self._inverses[key] = found.inverse
        return found.values

    def _note(self, s: Segment, names: Sequence[str], rows: int) -> None:
        """Keep what was estimated on a segment, with what was before."""
        known = self.estimates.get(s, Estimated((), 0))
        self.estimates[s] = Estimated(tuple(dict.fromkeys((*known.names, *names))), max(known.rows, rows))

    def _play(self, player: Player, values: Values, s: Segment, rows: int | None = None) -> Array:
        """Replay a segment or its first rows; shape (rows, names of the player)."""
        m = self.options.oversample
        n_steps = ((len(s) if rows is None else min(rows, len(s))) - 1) * m
        segment = (s.begin * m, n_steps)
        values = self.values_in(values, s.recording)
        return player.play(values, self.data[s.recording], segment, self.period / m, m)

    def _table(self, r: Recording) -> Array:
        """Inputs at every step, shape (steps + 1, columns)."""
        m = self.options.oversample
        places = np.arange((len(r) - 1) * m + 1) / m
        columns = []
        for signal, row in self.part.columns:
            values = r[signal]
            if row == "start":
                columns.append(values[np.maximum(np.ceil(places).astype(int) - 1, 0)])
            else:
                columns.append(values if m == 1 else CubicSpline(np.arange(len(r)), values)(places))
        return np.ascontiguousarray(np.column_stack(columns or [np.zeros(len(places))]))

    def _measured(self, r: Recording) -> Array:
        return np.column_stack([r[self.part.compared[name]] for name in self.outputs])

    def _joined(self, values: Mapping[str, Array]) -> Array:
        return np.concatenate([values[name] for name in self.recordings])

    def _in_use(self) -> Mask:
        unknown = 1 if self.part.begins_before_its_rows else 0
        settle = max(round(self.options.settle / self.period), unknown)
        used = {name: np.ones(len(r)) for name, r in self.recordings.items()}
        for s in self.segments:
            used[s.recording][s.begin : s.begin + settle] = 0.0
        return np.asarray(self.compared_rows(self._joined(used)) > 0.0)


def _segments(r: Recording, windows: Sequence[float]) -> list[Segment]:
    """Cut a recording into windows of the smallest length [s]; a short rest joins the last one."""
    n = len(r)
    length = n if not windows else max(2, round(min(windows) / r.period))
    edges = [*range(0, n - length // 2, length), n]
    return [Segment(r.name, begin, end) for begin, end in itertools.pairwise(edges)]
