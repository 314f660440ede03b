"""
The numbers that a run is judged by.

    zeta, frequency, growth_per_cycle   dominant mode of the compared signal
    rms_s_des, rms_s_act                RMS(signal - reference)/offset of signal and reproduced motion
    phase_deg                           phase of the reproduced motion against the reference at the
                                        reference's mode, negative: lagging
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from master.recording.recorder import Result
from master.system.config import Compare

from .modes import Mode, Projection, dominant_mode, dominant_of, poles_of

Metrics = dict[str, float | None]
Floats = NDArray[np.float64]

NAMES = (
    "zeta",
    "frequency",
    "growth_per_cycle",
    "rms_s_des",
    "rms_s_act",
    "phase_deg",
    "zeta_reference",
    "frequency_reference",
)
UNITS = {"frequency": "Hz", "phase_deg": "deg", "frequency_reference": "Hz"}
"""Units of those that have one other than 1."""


def compute_metrics(result: Result, compare: Compare) -> Metrics:
    """
    Compute all metrics; None where a signal is not given or nothing oscillates.

    On one thread: more would only wait for each other, and might round otherwise.
    """
    with _blas().limit(limits=1):
        return metrics_on_this_thread(result, compare)


@lru_cache(maxsize=1)
def _blas() -> ThreadpoolController:
    return ThreadpoolController()


@np.errstate(over="ignore")
def metrics_on_this_thread(result: Result, compare: Compare) -> Metrics:
    """Compute all metrics as `compute_metrics` does, in a process that uses one thread anyway."""
    found: Metrics = dict.fromkeys(NAMES)
    columns = _finite_columns(result, compare)
    signal = columns[compare.signal]
    if len(signal) < 8:
        return found
    step = float(result.time[1] - result.time[0])
    mode = dominant_mode(signal, step)
    if mode is not None:
        found |= {
            "zeta": mode.zeta,
            "frequency": mode.frequency,
            "growth_per_cycle": mode.growth_per_cycle,
        }
    if compare.reference is not None:
        found |= _against_reference(columns, compare, columns[compare.reference], step)
    return {name: _finite(value) for name, value in found.items()}


def _finite_columns(result: Result, compare: Compare) -> dict[str, Floats]:
    """
    Return what is compared, by signal, shape (rows,), each by itself in memory: it is gone over many times.

    Without what follows the first value that is not finite: a run that diverged ends with one.
    """
    named = [n for n in (compare.signal, compare.reproduced, compare.reference) if n is not None]
    columns = {n: np.ascontiguousarray(result[n]) for n in named}
    n = min(_n_finite(column) for column in columns.values())
    return {name: column[:n] for name, column in columns.items()}


def _n_finite(values: Floats) -> int:
    """Return how many values there are before the first that is not finite."""
    is_finite = np.isfinite(values)
    return len(values) if is_finite.all() else int(is_finite.argmin())


def _against_reference(
    columns: Mapping[str, Floats], compare: Compare, reference: Floats, step: float
) -> Metrics:
    found: Metrics = {"rms_s_des": _rms(columns[compare.signal] - reference) / compare.offset}
    known = _reference(reference.tobytes(), step)
    mode = known.mode
    if mode is not None:
        found |= {"zeta_reference": mode.zeta, "frequency_reference": mode.frequency}
    if compare.reproduced is not None:
        reproduced = columns[compare.reproduced]
        found["rms_s_act"] = _rms(reproduced - reference) / compare.offset
        if mode is not None:
            ratio = known.projection.amplitudes(reproduced)[known.place] / mode.amplitude
            found["phase_deg"] = math.degrees(math.atan2(ratio.imag, ratio.real))
    return found


@dataclass(frozen=True)
class _Reference:
    """The dominant mode of a reference, its place among the poles, and the projection on all of them."""

    mode: Mode | None
    place: int
    projection: Projection


@lru_cache(maxsize=4)
def _reference(values: bytes, step: float) -> _Reference:
    """Return what is compared with; that of many runs of a campaign is the same."""
    y = np.frombuffer(values)
    poles = poles_of(y, step)
    projection = Projection(poles, step, len(y))
    mode = dominant_of(poles, projection.amplitudes(y), len(y) * step)
    place = 0 if mode is None else int(np.argmin(np.abs(poles - mode.pole)))
    return _Reference(mode, place, projection)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values * values)))


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
