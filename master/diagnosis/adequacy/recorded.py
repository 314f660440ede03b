"""What was recorded that a residual may follow, as columns; never the residual's own past."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.signal import lfilter, savgol_filter

from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.memory import lagged
from master.diagnosis.search.study import Study

SAME = 0.9999  # correlation of two signals that are one
MOST_SIGNALS = 14
MOST_SHAKING = 2  # signals that are passed through resonators
WINDOW = 21  # samples, of the polynomial that gives a rate
ORDER = 3  # of that polynomial
TIMES = (3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0)  # samples, of leaky integrals
TIMES_OF_TREES = (10.0, 100.0, 1000.0)
LAGS = (5, 20, 80)  # samples
N_RESONATORS = 22
RESONANCES = (0.002, 0.06)  # of the sampling rate
DAMPINGS = (0.02, 0.2)
LONGEST = 0.25  # of a recording, for a time constant


@dataclass(frozen=True)
class Recorded:
    """
    Signals of a part over all samples, by name, shape (samples,), and columns made of them on compared rows.

    The signals are what drives the part, what is in the slots of its models along a replay, and the rates of
    both; of signals that are one, only the first is kept.
    """

    study: Study

    @cached_property
    def driving(self) -> dict[str, Array]:
        """What was measured and drives the part."""
        bench = self.study.bench
        return {m.signal: bench.signal(m.signal) for m in bench.part.columns}

    @cached_property
    def signals(self) -> dict[str, Array]:
        """All signals that differ from each other."""
        kept: dict[str, Array] = {}
        self._keep(kept, self.driving)
        for place, own in self.study.signals.items():
            self._keep(kept, {f"{place} {role}": values for role, values in own.items()})
        self._keep(kept, {f"rate of {n}": self.rate(v) for n, v in self.driving.items()})
        return kept

    @cached_property
    def accelerations(self) -> dict[str, Array]:
        """Fastest rates of what drives the part: what shakes a mode that is in no model."""
        kept: dict[str, Array] = {}
        rates = {n: self.rate(v) for n, v in self.driving.items()}
        self._keep(kept, {f"second rate of {n}": self.rate(v) for n, v in rates.items()})
        self._keep(kept, {f"rate of {n}": v for n, v in rates.items()})
        return dict(list(kept.items())[:MOST_SHAKING])

    @cached_property
    def linear_parts(self) -> dict[str, Array]:
        """Linear dynamics in words, and their columns, shape (rows, m): signals, memories, modes."""
        period = self.study.bench.period
        parts: dict[str, Array] = {}
        for name, values in self.signals.items():
            parts[name] = self._rows([values])
            for length, column in self._integrals(values, TIMES).items():
                parts[f"a memory of {length * period:.3g} s of {name}"] = self._rows([column])
        for name, values in self.accelerations.items():
            parts[name] = self._rows([values])
            for frequency, columns in self._resonators(values).items():
                parts[f"a mode at {frequency / period:.3g} Hz, driven by {name}"] = self._rows(columns)
        return parts

    @cached_property
    def linear(self) -> Array:
        """Columns for linear dynamics, shape (rows, m)."""
        return np.hstack(list(self.linear_parts.values()))

    @cached_property
    def nonlinear(self) -> Array:
        """Columns for trees: signals, sizes, signs, integrals, lags, time; shape (rows, m)."""
        columns = []
        for values in self.signals.values():
            columns += [values, *self._integrals(values, TIMES_OF_TREES).values()]
            columns += [self._each(partial(_late, lag=lag), values) for lag in LAGS]
        columns.append(self.study.bench.times)
        return self._rows(columns)

    @cached_property
    def times(self) -> Array:
        """Time of the compared rows over all recordings, one after the other [s], shape (rows,)."""
        rows = np.arange(len(self.study.measured), dtype=np.float64)
        return rows * self.study.bench.row_period

    def on_rows(self, values: Array) -> Array:
        """A signal on the compared rows, shape (rows,)."""
        return self.study.bench.compared_rows(values)

    def rate(self, values: Array) -> Array:
        """Rate of a signal (samples,), smoothed by a polynomial."""
        period = self.study.bench.period

        def one(v: Array) -> Array:
            window = min(WINDOW, len(v) - 1 + len(v) % 2)
            smoothed = savgol_filter(v, window, min(ORDER, window - 1), deriv=1, delta=period)
            return np.asarray(smoothed, dtype=np.float64)

        return self._each(one, values)

    def _keep(self, kept: dict[str, Array], more: Mapping[str, Array]) -> None:
        for name, values in more.items():
            if len(kept) < MOST_SIGNALS and np.ptp(values) > 0.0 and np.isfinite(values).all():
                centred = values - values.mean()
                size = float(np.sqrt(centred @ centred))
                alike = (abs(_correlation(centred, size, other)) > SAME for other in kept.values())
                if not any(alike):
                    kept[name] = values

    def _integrals(self, values: Array, times: tuple[float, ...]) -> dict[float, Array]:
        """Leaky integrals by their time constant [samples]."""
        longest = LONGEST * min(len(r) for r in self.study.bench.recordings.values())
        return {t: self._each(partial(lagged, ratio=1.0 / t), values) for t in times if t < longest}

    def _resonators(self, values: Array) -> dict[float, list[Array]]:
        """Answers of resonators and their differences by frequency [1/sample]."""
        found: dict[float, list[Array]] = {}
        for frequency in np.geomspace(*RESONANCES, N_RESONATORS).tolist():
            columns = found.setdefault(frequency, [])
            for damping in DAMPINGS:
                pole = np.exp(2.0 * np.pi * frequency * (-damping + 1j * np.sqrt(1.0 - damping**2)))
                gain = 1.0 - abs(pole)

                def one(v: Array, pole: complex = pole, gain: float = gain) -> Array:
                    return np.asarray(lfilter([gain], [1.0, -2.0 * pole.real, abs(pole) ** 2], v))

                column = self._each(one, values)
                columns += [column, np.concatenate([[0.0], np.diff(column)])]
        return found

    def _each(self, function: Callable[[Array], Array], values: Array) -> Array:
        """Apply a filter to each recording by itself."""
        bench = self.study.bench
        parts = []
        first = 0
        for recording in bench.recordings.values():
            parts.append(function(values[first : first + len(recording)]))
            first += len(recording)
        return np.concatenate(parts)

    def _rows(self, columns: list[Array]) -> Array:
        return np.column_stack([self.on_rows(c) for c in columns])


def _correlation(centred: Array, size: float, other: Array) -> float:
    away = other - other.mean()
    return float(centred @ away / max(size * float(np.sqrt(away @ away)), 1e-300))


def _late(values: Array, lag: int) -> Array:
    lag = min(lag, len(values) - 1)
    return np.concatenate([np.full(lag, values[0]), values[: len(values) - lag]])
