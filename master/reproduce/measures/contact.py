"""
The contact as the paper's formulas have it, to hold the runs against.

    m_s s^2 (m_e s^2 + C s + K) + (k_m + c_m s)(k_p + c_p s) = 0,   K = k_m + k_p, C = c_m + c_p     (1, 11)
    D0 = m_e + C T + K T^2,   a = (2 m_e + C T)/D0,   b = -m_e/D0                                    (16)
    c = (c_m + k_m T)(c_p + k_p T)/D0,   e = c_m c_p/D0,   c + d + e = k_m k_p T^2/D0
    G(q) = (c + d q + e q^2)/(1 - a q - b q^2),   q = exp(-s T)                                      (15)

Source   Paper, Eqs. 1, 11, 15, 16, with the errata of `errata.py`; backward difference.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Loop:
    """Spacecraft and contact parameters [kg, N/m, N s/m]."""

    m_s: float
    m_e: float
    k_m: float
    c_m: float
    k_p: float
    c_p: float

    @cached_property
    def pole(self) -> complex:
        """Pole of the ideal loop's slow mode, positive imaginary part [1/s]."""
        K, C = self.k_m + self.k_p, self.c_m + self.c_p
        mechanism = np.polymul([self.m_s, 0.0, 0.0], [self.m_e, C, K])
        force = np.polymul([self.c_m, self.k_m], [self.c_p, self.k_p])
        roots = np.roots(np.polyadd(mechanism, force))
        return complex(min((r for r in roots if r.imag > 0.0), key=abs))


def process_parameters(loop: Loop, T: float, k_p: Floats) -> Floats:
    """Return a..e of the backward difference for each rope stiffness k_p [N/m], shape (n, 5)."""
    K, C = loop.k_m + k_p, loop.c_m + loop.c_p
    D0 = loop.m_e + C * T + K * T * T
    c = (loop.c_m + loop.k_m * T) * (loop.c_p + k_p * T) / D0
    e = loop.c_m * loop.c_p / D0
    d = loop.k_m * k_p * T * T / D0 - c - e
    return np.stack([(2.0 * loop.m_e + C * T) / D0, -loop.m_e / D0, c, d, e], axis=1)


def response(Y: Floats, w: float, T: float) -> NDArray[np.complex128]:
    """Return G at w [rad/s] for process parameters of shape (n, 5)."""
    q = np.exp(-1j * w * T)
    a, b, c, d, e = Y.T
    return np.asarray((c + d * q + e * q * q) / (1.0 - a * q - b * q * q))
