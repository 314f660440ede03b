"""The motion that a rig is commissioned with: a swept sine of small amplitude, at rest before and after."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

REST_BEFORE = 0.5
REST_AFTER = 1.5
TAPER = 0.3
"""Times [s] of rest, and of the amplitude on its way up and down."""


@dataclass(frozen=True)
class Chirp:
    """Amplitude [m], length of the sweep [s], and its frequencies [Hz]."""

    amplitude: float = 5e-4
    duration: float = 6.0
    lowest: float = 0.3
    highest: float = 15.0

    @property
    def stop_time(self) -> float:
        """Time [s] with the rest at both ends."""
        return REST_BEFORE + self.duration + REST_AFTER

    def samples(self, period: float) -> Floats:
        """Return the displacement [m] at 0, period, ... up to the stop time."""
        t = period * np.arange(round(self.stop_time / period) + 1) - REST_BEFORE
        inside = np.clip(t, 0.0, self.duration)
        rate = (self.highest - self.lowest) / self.duration
        phase = 2.0 * np.pi * (self.lowest * inside + 0.5 * rate * inside**2)
        nearest_end = np.minimum(inside, self.duration - inside)
        envelope = np.sin(0.5 * np.pi * np.clip(nearest_end / TAPER, 0.0, 1.0)) ** 2
        return np.asarray(self.amplitude * envelope * np.sin(phase))
