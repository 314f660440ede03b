"""
Design of the displacement phase delay compensation (DPDC), from the plant as it is coupled.

    w1^2  = (p - sqrt(p^2 - 4 k_m k_p/(m_s m_e)))/2,   p = k_m/m_e + k_p/m,   m = m_e m_s/(m_e + m_s)     (3)
    phi   = lag of the reproduced motion after the simulated one at w1, without DPDC
    alpha = (1 + sin phi)/(1 - sin phi),   T = 1/(w_max sqrt(alpha)),   K = gain/sqrt(alpha)         (23, 24)
    gain  = 1 (paper) or 1/|M(w1)| (plant),   M = reproduced over simulated motion without DPDC

The lag holds all that is between the two rows: the plant, its hold and dead time, delays of connections.
With ranges of m_s, m_e, k_m, k_p the design, phase and gain, is for the largest frequency, as in Eq. 24; what
is left over the range is read from the coupled system with the designed DPDC in it.
Source   Paper, Sec. III-B, IV-C, Eqs. 3, 22-24; Eq. 3 prints neither the square nor the half of w^2 clearly.
Deviation  The paper's K undoes the gain of the lead alone; `amplitude: plant`, ours, the plant's too.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from master.analysis.closed_loop.linearise import Linearisation, changed
from master.analysis.measures.frequency import response_from
from master.errors import ConfigError
from master.experiment.experiment import Experiment
from master.experiment.phase_lead import LeadTask, is_switched_off, lead_task
from master.stepping.simulate import SlaveFactory, load
from master.system.config import PhaseLead

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_N_SHOWN = 5
_STEEPEST = 1.5


@dataclass(frozen=True)
class Design:
    """
    Lead and what it leaves.

    `phase`, `frequency` and `gain` are the compensator's parameters; `frequencies` [Hz] over the range, and
    the reproduced over the simulated motion there, without and with the lead.
    """

    phase: float
    frequency: float
    gain: float
    frequencies: Floats
    plain: Complexes
    led: Complexes

    @property
    def alpha(self) -> float:
        """Ratio of the lead's corner frequencies."""
        return (1.0 + math.sin(self.phase)) / (1.0 - math.sin(self.phase))

    @property
    def time_constant(self) -> float:
        """Time constant of the lead's pole [s]."""
        return 1.0 / (2.0 * math.pi * self.frequency * math.sqrt(self.alpha))

    @property
    def gain_at_rest(self) -> float:
        """K of Eq. 22, in the paper's convention."""
        return self.gain / math.sqrt(self.alpha)

    @property
    def lag(self) -> Floats:
        """Lag without the lead [rad]."""
        return -np.angle(self.plain)

    @property
    def left(self) -> Floats:
        """Lag with the lead [rad]."""
        return -np.angle(self.led)

    def as_dict(self) -> dict[str, Any]:
        """Fields for JSON."""
        return {
            "dpdc_phase": self.phase,
            "dpdc_frequency": self.frequency,
            "dpdc_gain": self.gain,
            "alpha": self.alpha,
            "T_lead": self.time_constant,
            "K": self.gain_at_rest,
            "frequency": self.frequencies.tolist(),
            "lag_deg": np.degrees(self.lag).tolist(),
            "left_deg": np.degrees(self.left).tolist(),
            "plant_magnitude": np.abs(self.plain).tolist(),
            "magnitude": np.abs(self.led).tolist(),
        }


def dynamics_frequency(m_s: float, m_e: float, k_m: float, k_p: float) -> float:
    """Lower docking frequency of Eq. 3 [Hz]."""
    p = k_m / m_e + k_p * (m_e + m_s) / (m_e * m_s)
    square = 0.5 * (p - math.sqrt(p * p - 4.0 * k_m * k_p / (m_s * m_e)))
    return math.sqrt(square) / (2.0 * math.pi)


def design(experiment: Experiment, wanted: PhaseLead, factory: SlaveFactory = load) -> Design:
    """
    Design the DPDC of one FMU.

    Args:
        experiment: The system; its `compare` section names the simulated and the reproduced motion.
        wanted: The FMU, what the amplitude is for, and least and largest m_s, m_e, k_m, k_p; those not given
            are the system's own values.
        factory: Makes the slaves.

    Raises:
        ConfigError: If the system does not have what the design needs.
    """
    fmu = wanted.fmu
    task = lead_task(experiment.system, experiment.compare, wanted)
    linearisation = Linearisation(experiment, factory)
    low, high = _range(task)
    frequencies = np.linspace(low, high, 1 if low == high else _N_SHOWN)

    def reproduced(**changes: float) -> Complexes:
        coupled = linearisation.coupled({f"{fmu}.{key}": value for key, value in changes.items()})
        return response_from(coupled, task.wire, task.reproduced, frequencies)

    plain = reproduced(dpdc=0.0)
    phase = float(-np.angle(plain[-1]))
    if not 0.0 <= phase <= _STEEPEST:
        degrees = math.degrees(phase)
        raise ConfigError(
            [f"dpdc: no lead for this lag, got {degrees:.1f} deg at {high:.4g} Hz, expected 0 to 86"]
        )
    gain = 1.0 if wanted.amplitude == "paper" else _against(float(np.abs(plain[-1])), high)
    led = reproduced(dpdc=1.0, **_values(experiment, fmu, phase=phase, frequency=high, gain=gain))
    return Design(phase, high, gain, frequencies, plain, led)


def designed(experiment: Experiment, factory: SlaveFactory = load) -> Experiment:
    """
    Set the compensator to the design that the experiment asks for, except for what is set by hand.

    Without a wish, or where the lead is switched off, the experiment is returned as it is.
    """
    wanted = experiment.phase_lead
    if wanted is None or is_switched_off(experiment.system, wanted):
        return experiment
    found = design(experiment, wanted, factory)
    values = _values(experiment, wanted.fmu, phase=found.phase, frequency=found.frequency, gain=found.gain)
    chosen = {f"{wanted.fmu}.{key}": value for key, value in values.items()}
    kept = {signal: value for signal, value in chosen.items() if signal not in experiment.overridden}
    return replace(experiment, system=changed(experiment.system, kept))


def _values(
    experiment: Experiment, fmu: str, *, phase: float, frequency: float, gain: float
) -> dict[str, float]:
    """Return the compensator's parameters; one without a gain of its own has the paper's."""
    known = experiment.system.instances[fmu].description.by_name
    values = {"dpdc_phase": phase, "dpdc_frequency": frequency, "dpdc_gain": gain}
    return {name: value for name, value in values.items() if name in known}


def _against(magnitude: float, frequency: float) -> float:
    """Gain that undoes a magnitude."""
    if not magnitude > 0.0:
        raise ConfigError(
            [f"dpdc: no motion at {frequency:.4g} Hz, got amplitude {magnitude}, expected above 0"]
        )
    return 1.0 / magnitude


def _range(task: LeadTask) -> tuple[float, float]:
    """Least and largest frequency over the corners of the ranges; Eq. 3 is monotonic in each value."""
    found = [dynamics_frequency(*values) for values in itertools.product(*task.spans)]
    return min(found), max(found)
