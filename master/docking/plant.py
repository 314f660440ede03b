"""
The third-order-plus-delay form of a motion simulator, fitted to its response.

    M(s) = K_p w_v^2/(s^3 + 2 z w_v s^2 + w_v^2 s + K_p w_v^2) exp(-dead_time s)

The response is that of the FMU to a command held over each step h; the hold, exp(-s h/2) sinc, is taken
out before the fit, as the form has its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from master.analysis.identify.realisation import realise
from master.analysis.identify.responses import Question, measure
from master.analysis.measures.frequency import response
from master.analysis.state_space import StateSpace
from master.errors import ConfigError, expected
from master.fmi.description import Description
from master.stepping.simulate import SlaveFactory, load
from master.system.graph import Instance

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

AXES = {
    "x": ("pose_cmd[1]", "pose[1]"),
    "y": ("pose_cmd[2]", "pose[2]"),
    "z": ("s_cmd", "s_act"),
    "roll": ("pose_cmd[4]", "pose[4]"),
    "pitch": ("pose_cmd[5]", "pose[5]"),
    "yaw": ("pose_cmd[6]", "pose[6]"),
}
STEP_SIZE = 1e-3
LOWEST, HIGHEST = 0.1, 5.0
TABULATED = np.array([0.1, 0.43, 0.87, 0.97, 2.6, 5.0])
_N_FITTED = 80


@dataclass(frozen=True)
class ThirdOrder:
    """Parameters of `motion_simulator_linear`: [1/s], [rad/s], [1], [s]."""

    K_p: float
    w_v: float
    z: float
    dead_time: float

    def at(self, frequencies: Floats) -> Complexes:
        """Frequency response."""
        s = 2j * np.pi * frequencies
        w2 = self.w_v**2
        denominator = s**3 + 2.0 * self.z * self.w_v * s**2 + w2 * s + self.K_p * w2
        return np.asarray(self.K_p * w2 / denominator * np.exp(-s * self.dead_time))


@dataclass(frozen=True)
class Fit:
    """The form against the response over LOWEST to HIGHEST Hz; `measured` at the frequencies TABULATED."""

    form: ThirdOrder
    magnitude_error: float
    phase_error: float
    measured: Complexes

    def as_dict(self) -> dict[str, Any]:
        """Fields for JSON; phases in degrees."""
        return {
            **vars(self.form),
            "largest_magnitude_error": self.magnitude_error,
            "largest_phase_error_deg": self.phase_error,
        }


def linearise(description: Description, axis: str, factory: SlaveFactory = load) -> StateSpace:
    """
    Realise one axis of a motion simulator at its neutral pose.

    Raises:
        ConfigError: If the FMU has no such axis.
        FmuError: If it fails.
    """
    command, motion = AXES[axis]
    faults = [
        f"--axis: {description.model_name} has none, got {axis!r}, {expected(name, description.by_name)}"
        for name in (command, motion)
        if name not in description.by_name
    ]
    if faults:
        raise ConfigError(faults[:1])
    question = Question(
        instance=Instance(description.model_name, description, 1, {}),
        inputs=(description.by_name[command],),
        starts=(),
        outputs=(description.by_name[motion],),
        held=(0.0,),
        step_size=STEP_SIZE,
        t0=0.0,
    )
    return realise(measure(question, factory))


def unheld(system: StateSpace, frequencies: Floats) -> Complexes:
    """Response without the hold of the command."""
    half = np.pi * frequencies * STEP_SIZE
    return np.asarray(response(system, STEP_SIZE, frequencies) * np.exp(1j * half) / np.sinc(half / np.pi))


def fit(system: StateSpace, guess: ThirdOrder) -> Fit:
    """Fit the third order with dead time to a realised axis, from a first guess."""
    frequencies = np.geomspace(LOWEST, HIGHEST, _N_FITTED)
    measured = unheld(system, frequencies)

    def errors(p: Floats) -> Floats:
        relative = _form(p).at(frequencies) / measured - 1.0
        return np.concatenate([relative.real, relative.imag])

    start = [*np.log([guess.K_p, guess.w_v, guess.z]), guess.dead_time]
    bounds = ([-np.inf] * 3 + [0.0], [np.inf] * 3 + [0.1])
    found = least_squares(errors, start, bounds=bounds, x_scale=[1.0, 1.0, 1.0, 1e-3], xtol=1e-14, ftol=1e-14)
    return judge(system, _form(found.x))


def _form(p: Floats) -> ThirdOrder:
    """Parameters from the logarithms of K_p, w_v, z, and the dead time."""
    K_p, w_v, z = np.exp(p[:3])
    return ThirdOrder(float(K_p), float(w_v), float(z), float(p[3]))


def judge(system: StateSpace, form: ThirdOrder) -> Fit:
    """Compare a form with a realised axis."""
    frequencies = np.geomspace(LOWEST, HIGHEST, _N_FITTED)
    ratio = form.at(frequencies) / unheld(system, frequencies)
    return Fit(
        form=form,
        magnitude_error=float(np.max(np.abs(np.abs(ratio) - 1.0))),
        phase_error=float(np.degrees(np.max(np.abs(np.angle(ratio))))),
        measured=unheld(system, TABULATED),
    )
