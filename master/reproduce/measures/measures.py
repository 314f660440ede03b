"""Numbers of a run, each by its name; the claims are inequalities between them and their bounds."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from master.evaluation.metrics import NAMES, Metrics, compute_metrics
from master.evaluation.modes import Mode, dominant_mode, project
from master.experiment.experiment import Experiment
from master.recording.recorder import Result

from . import contact
from .poles import cancellation, judged

Floats = NDArray[np.float64]

FIRST_SECONDS = 2.0
SETTLING = 0.4


@dataclass(frozen=True)
class Trace:
    """A run that is over, with what several measures need of it."""

    experiment: Experiment
    result: Result

    @cached_property
    def metrics(self) -> Metrics:
        """Metrics of `dockloop run`."""
        compare = self.experiment.compare
        return {} if compare is None else compute_metrics(self.result, compare)

    @cached_property
    def loop(self) -> contact.Loop:
        """Parameters of the real contact and of the spacecraft."""
        return contact.Loop(
            **{k: self.parameter("ideal", k) for k in ("m_s", "m_e", "k_m", "c_m", "k_p", "c_p")}
        )

    @cached_property
    def mode(self) -> Mode | None:
        """Dominant mode of the simulated motion."""
        return dominant_mode(self.result["spacecraft.s_des"], self.step)

    @property
    def step(self) -> float:
        """Step size [s]."""
        return self.experiment.grid.step_size

    def parameter(self, instance: str, name: str) -> float:
        """Value that the run had."""
        return float(self.experiment.system.instances[instance].value_of(name) or 0.0)

    def rows(self, seconds: float) -> int:
        """Number of steps in a time."""
        return round(seconds / self.step)


def _amplitude_to_motion(trace: Trace, force: str, motion: str, mode: Mode | None) -> complex:
    """Ratio of the force's amplitude to the motion's at the mode of the run, where the start has faded."""
    if mode is None:
        return complex(math.nan, math.nan)
    begin = round(SETTLING * len(trace.result.time))
    pair = np.array([mode.pole, mode.pole.conjugate()])
    amplitudes = [project(trace.result[s][begin:], trace.step, pair)[0] for s in (force, motion)]
    return complex(amplitudes[0] / amplitudes[1])


def force_phase(trace: Trace, force: str) -> float:
    """Phase of a force after s_des against that of the ideal force [deg]; negative: it lags."""
    found = _amplitude_to_motion(trace, force, "spacecraft.s_des", trace.mode)
    reference = dominant_mode(trace.result["ideal.s"], trace.step)
    ideal = _amplitude_to_motion(trace, "ideal.f", "ideal.s", reference)
    return math.degrees(cmath.phase(found / ideal)) if abs(found) > 0.0 else math.nan


def _deviation(trace: Trace) -> float:
    zeta = trace.metrics["zeta"]
    reference = trace.metrics["zeta_reference"]
    return math.nan if zeta is None or reference is None else abs(zeta - reference)


def _frequency_error(trace: Trace) -> float:
    found = trace.metrics["frequency_reference"] or math.nan
    return abs(found / (trace.loop.pole.imag / (2.0 * math.pi)) - 1.0)


def _damping_error(trace: Trace) -> float:
    pole = trace.loop.pole
    return abs((trace.metrics["zeta_reference"] or math.nan) + pole.real / abs(pole))


def _last_second(trace: Trace, signal: str) -> float:
    return float(np.max(np.abs(trace.result[signal][-trace.rows(1.0) :])))


def _offset_at_end(trace: Trace) -> float:
    n = trace.rows(FIRST_SECONDS)
    return float(np.mean((trace.result["motion_simulator.s_act"] - trace.result["ideal.s"])[-n:]))


def identified(trace: Trace) -> Floats:
    """Process parameters over time, shape (rows, 5)."""
    return np.stack([trace.result[f"compensator.{name}"] for name in "abcde"], axis=1)


def stiffness(trace: Trace) -> Floats:
    """Stiffness of the rope over time [N/m], shape (rows,)."""
    amplitude = trace.parameter("contact", "k_p_amplitude")
    frequency = trace.parameter("contact", "k_p_frequency")
    variation = amplitude * np.sin(2.0 * math.pi * frequency * trace.result.time)
    return np.asarray(trace.loop.k_p + variation)


def _response_error(trace: Trace) -> float:
    """Largest relative error of the identified response at the dynamics frequency, after the first second."""
    w = abs(trace.loop.pole)
    rows = slice(trace.rows(1.0), None, 20)
    theory = contact.process_parameters(trace.loop, trace.step, stiffness(trace)[rows])
    ratio = contact.response(identified(trace)[rows], w, trace.step) / contact.response(theory, w, trace.step)
    return float(np.max(np.abs(ratio - 1.0)))


def _moved_from_prior(trace: Trace) -> float:
    Y = identified(trace)[:, 2:]
    return float(np.max(np.abs(Y[-1] / Y[0] - 1.0)))


def _single_error(trace: Trace) -> float:
    """Largest relative error of a single process parameter at the end."""
    theory = contact.process_parameters(trace.loop, trace.step, stiffness(trace)[-1:])[0]
    return float(np.max(np.abs(identified(trace)[-1] / theory - 1.0)))


def _regressor(trace: Trace) -> Floats:
    n = trace.rows(FIRST_SECONDS)
    f, s = trace.result["contact.f_act"][:n], trace.result["motion_simulator.s_act"][:n]
    return np.stack([f[1:-1], f[:-2], -s[2:], -s[1:-1], -s[:-2]], axis=1)


def _condition(trace: Trace) -> float:
    H = _regressor(trace)
    return float(np.linalg.cond(H / np.linalg.norm(H, axis=0)))


def _spread_of_c(trace: Trace) -> float:
    """Standard deviation of c by ideal least squares over two seconds, in units of c."""
    H = _regressor(trace)
    scale = np.linalg.norm(H, axis=0)
    _, singular, right = np.linalg.svd(H / scale, full_matrices=False)
    deviations = np.linalg.norm(right.T / singular, axis=1) / scale
    c = contact.process_parameters(trace.loop, trace.step, stiffness(trace)[:1])[0, 2]
    return float(trace.parameter("force_sensor", "sigma") * deviations[2] / c)


def _distorted_share(trace: Trace) -> float:
    """Share of rows whose attribute parameters are not regular and physical, or one off by its own value."""
    names = ("m_e", "k_m", "c_m", "k_p", "c_p")
    found = np.stack([trace.result[f"compensator.{n}_id"] for n in names], axis=1)
    truth = np.array([getattr(trace.loop, n) for n in names])
    far = np.max(np.abs(found / truth - 1.0), axis=1) > 1.0
    return float(np.mean(far | (trace.result["compensator.attributes_valid"] < 0.5)))


def _growth_rate(trace: Trace) -> float:
    return math.nan if trace.mode is None else trace.mode.pole.real


def _pole_deviation(trace: Trace) -> float:
    """Distance of the dominant pole from the real docking's, in units of its modulus."""
    found = judged(trace.experiment)
    if found.dominant is None or found.reference is None:
        return math.nan
    s, ideal = (complex(p.s.real, abs(p.s.imag)) for p in (found.dominant, found.reference))
    return abs(s - ideal) / abs(ideal)


def _zeta_of_pole(trace: Trace) -> float:
    """Difference of the damping ratios of the dominant pole and of the run."""
    found = judged(trace.experiment).dominant
    zeta = trace.metrics["zeta"]
    return math.nan if found is None or zeta is None else abs(found.zeta - zeta)


Measure = Callable[[Trace], float | None]


def _metric(name: str) -> Measure:
    return lambda trace: trace.metrics.get(name)


MEASURES: Mapping[str, Measure] = {
    **{name: _metric(name) for name in NAMES},
    "zeta_deviation": _deviation,
    "frequency_error": _frequency_error,
    "damping_error": _damping_error,
    "f_mea_phase": lambda trace: force_phase(trace, "force_sensor.f_mea"),
    "f_des_phase": lambda trace: force_phase(trace, "compensator.f_des"),
    "growth_rate": _growth_rate,
    "pole_deviation": _pole_deviation,
    "zeta_of_pole": _zeta_of_pole,
    "cancellation": lambda trace: cancellation(trace.experiment),
    "fastest_pole": lambda trace: judged(trace.experiment).fastest,
    "df_at_end": lambda trace: _last_second(trace, "compensator.df"),
    "offset_at_end": _offset_at_end,
    "response_error": _response_error,
    "moved_from_prior": _moved_from_prior,
    "single_error": _single_error,
    "condition": _condition,
    "spread_of_c": _spread_of_c,
    "distorted_share": _distorted_share,
}

_POLES = "no noise: poles of the linearised FMUs"
_ALONE = "no noise: the real docking runs alone"

NOISELESS: Mapping[str, str] = {
    "frequency_error": _ALONE,
    "damping_error": _ALONE,
    "pole_deviation": _POLES,
    "cancellation": _POLES,
    "fastest_pole": _POLES,
}

MEANINGS: Mapping[str, str] = {
    "zeta": "zeta",
    "growth_per_cycle": "growth per cycle",
    "rms_s_des": "rms(s_des - ideal)/s0",
    "rms_s_act": "rms(s_act - ideal)/s0",
    "phase_deg": "phase of s_act",
    "zeta_deviation": "|zeta - zeta0|",
    "frequency_error": "|f/f_loop - 1|",
    "damping_error": "|zeta0 - zeta_loop|",
    "f_mea_phase": "phase of f_mea",
    "f_des_phase": "phase of f_des",
    "growth_rate": "growth rate",
    "pole_deviation": "|s - s0|/|s0|",
    "zeta_of_pole": "|zeta_pole - zeta_run|",
    "cancellation": "|pole - zero|/(|pole|^2 T/2)",
    "fastest_pole": "largest Re(s)",
    "df_at_end": "largest |dF|",
    "offset_at_end": "mean(s_act - ideal)",
    "response_error": "|G_id/G - 1|",
    "moved_from_prior": "largest change of c, d, e",
    "single_error": "largest error of a..e",
    "condition": "condition number",
    "spread_of_c": "std(c)/c",
    "distorted_share": "share of rows",
}
