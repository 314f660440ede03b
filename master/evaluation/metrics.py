"""
The numbers that a run is judged by.

    zeta, frequency, growth_per_cycle   dominant mode of the compared signal
    rms_s_des, rms_s_act                RMS(signal - reference)/offset of signal and reproduced motion
    phase_deg                           phase of the reproduced motion against the reference at the
                                        reference's mode, negative: lagging
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from master.recording.recorder import Result
from master.system.config import Compare

from .modes import Mode, dominant_mode, dominant_of, modes, project

Metrics = dict[str, float | None]
Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

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


@np.errstate(over="ignore")
def compute_metrics(result: Result, compare: Compare) -> Metrics:
    """
    Compute all metrics; None where a signal is not given or nothing oscillates.

    On one thread: more would only wait for each other, and might round otherwise.
    """
    with _blas().limit(limits=1):
        return _computed(result, compare)


@lru_cache(maxsize=1)
def _blas() -> ThreadpoolController:
    return ThreadpoolController()


def _computed(result: Result, compare: Compare) -> Metrics:
    found: Metrics = dict.fromkeys(NAMES)
    result = _finite_rows(result, compare)
    if len(result.time) < 8:
        return found
    step = float(result.time[1] - result.time[0])
    signal = result[compare.signal]
    mode = dominant_mode(signal, step)
    if mode is not None:
        found |= {
            "zeta": mode.zeta,
            "frequency": mode.frequency,
            "growth_per_cycle": mode.growth_per_cycle,
        }
    if compare.reference is not None:
        reference = result[compare.reference]
        found |= _against_reference(result, compare, reference, step)
    return {name: _finite(value) for name, value in found.items()}


def _finite_rows(result: Result, compare: Compare) -> Result:
    """Leave out what follows the first value that is not finite: a run that diverged ends with one."""
    named = [n for n in (compare.signal, compare.reproduced, compare.reference) if n is not None]
    finite = np.all([np.isfinite(result[n]) for n in named], axis=0)
    n = len(finite) if finite.all() else int(np.argmin(finite))
    return replace(result, time=result.time[:n], values=result.values[:n])


def _against_reference(result: Result, compare: Compare, reference: Floats, step: float) -> Metrics:
    found: Metrics = {"rms_s_des": _rms(result[compare.signal] - reference) / compare.offset}
    poles, amplitudes = _modes_of_reference(np.ascontiguousarray(reference).tobytes(), step)
    mode = dominant_of(poles, amplitudes, len(reference) * step)
    if mode is not None:
        found |= {"zeta_reference": mode.zeta, "frequency_reference": mode.frequency}
    if compare.reproduced is not None:
        reproduced = result[compare.reproduced]
        found["rms_s_act"] = _rms(reproduced - reference) / compare.offset
        if mode is not None:
            found["phase_deg"] = _phase_deg(reproduced, poles, amplitudes, mode, step)
    return found


@lru_cache(maxsize=4)
def _modes_of_reference(values: bytes, step: float) -> tuple[Complexes, Complexes]:
    """Poles and amplitudes of a signal; that of many runs of a campaign is the same."""
    return modes(np.frombuffer(values), step)


def _phase_deg(reproduced: Floats, poles: Complexes, amplitudes: Complexes, mode: Mode, step: float) -> float:
    place = int(np.argmin(np.abs(poles - mode.pole)))
    ratio = project(reproduced, step, poles)[place] / amplitudes[place]
    return math.degrees(math.atan2(ratio.imag, ratio.real))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values * values)))


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
