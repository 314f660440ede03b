"""
What is identified: the motion simulator from command to displacement, contact and sensor from there to force.

    M(s) = g K_p w_v^2/(s^3 + 2 z w_v s^2 + w_v^2 s + K_p w_v^2) exp(-tau s) H(s),   H: command held for T
    G(s) = -(k_m + c_m s)(k_p + c_p s)/(m_e s^2 + (c_m + c_p) s + k_m + k_p)/(1 + T_f s) exp(-delay s)

    k = k_m k_p/(k_m + k_p),   t_s = c_m/k_m + c_p/k_p - (c_m + c_p)/(k_m + k_p),   c = k t_s

The mass m_e is as given: a chirp shows ratios to it. Manipulator and rope look alike to the force, and a
record with noise does not tell them apart: how well the ratios k_m/k_p and c_m/c_p are known is in the fit.

Motion on straight lines from one sample to the next is smaller by exp(-(w T)^2/12): not on a real rig, once
in the contact and once in the sensor of the FMUs. T_f shows by the same kind of loss, so that it counts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .fit import Complexes, Floats, Form

PLANT = ("K_p", "w_v", "z", "dead_time", "gain")
"""Order of theta of the motion simulator; K_p, w_v, z as logarithms."""
CONTACT = ("stiffer", "stiffness_split", "damped", "damping_split", "T_f", "interpolations", "delay")
"""Order of theta of contact and sensor, the first four logarithms of factors on what is believed."""


@dataclass(frozen=True)
class Knowledge:
    """
    What is known besides the record.

    `stiffness_ratio`, `damping_ratio`: standard deviations of ln(k_m/k_p) and ln(c_m/c_p). `interpolations`
    and `spread`: how often a signal is interpolated on its way to the force, and how sure that is. `period`:
    of the samples [s]. `force_zero`: deviation [N] of the measured force where the displacement is 0 and the
    contact bears nothing; inf: not known, and the force at rest tells nothing.
    """

    period: float
    stiffness_ratio: float = 0.01
    damping_ratio: float = 0.01
    interpolations: float = 1.0
    spread: float = 1.0
    force_zero: float = np.inf


LONGEST_LAG = 0.5
LONGEST_DELAY = 0.1
"""Bounds [s] of what is searched for."""


def plant_form(period: float) -> Form:
    """Return the motion simulator; theta: K_p, w_v, z as logarithms, dead time [s], gain [1]."""

    def denominator(s: Complexes, theta: Floats) -> Complexes:
        K_p, w_v, z = np.exp(theta[:3])
        found: Complexes = s**3 + 2.0 * z * w_v * s**2 + w_v**2 * s + K_p * w_v**2
        return found

    def response(s: Complexes, theta: Floats) -> Complexes:
        K_p, w_v, _ = np.exp(theta[:3])
        held = -np.expm1(-s * period) / (s * period)
        found: Complexes = theta[4] * K_p * w_v**2 / denominator(s, theta) * np.exp(-s * theta[3]) * held
        return found

    lower = np.array([np.log(0.1), np.log(1.0), np.log(0.02), 0.0, 0.1])
    upper = np.array([np.log(1e4), np.log(1e5), np.log(20.0), LONGEST_DELAY, 10.0])
    return Form(response, denominator, 4, lower, upper, np.zeros(5), np.full(5, np.inf))


def plant_start(believed: Mapping[str, float]) -> Floats:
    """Return theta of what is believed."""
    logs = [np.log(believed[name]) for name in ("K_p", "w_v", "z")]
    return np.array([*logs, believed["dead_time"], 1.0])


def contact_form(believed: Mapping[str, float], knowledge: Knowledge, *, with_delay: bool) -> Form:
    """Return contact and sensor; theta as in `CONTACT`, without the delay if it is not asked for."""
    start = contact_start(believed)

    def denominator(s: Complexes, theta: Floats) -> Complexes:
        k_m, k_p, c_m, c_p = attributes(theta, start)
        found: Complexes = (believed["m_e"] * s**2 + (c_m + c_p) * s + k_m + k_p) * (1.0 + theta[4] * s)
        return found

    def response(s: Complexes, theta: Floats) -> Complexes:
        k_m, k_p, c_m, c_p = attributes(theta, start)
        late = np.exp(-s * theta[6]) if with_delay else 1.0
        between = np.exp(theta[5] * (s * knowledge.period) ** 2 / 12.0)
        found: Complexes = -(k_m + c_m * s) * (k_p + c_p * s) / denominator(s, theta) * between * late
        return found

    n = 7 if with_delay else 6
    lower = np.array([-5.0, -3.0, -10.0, -3.0, 0.0, -10.0, 0.0])[:n]
    upper = np.array([5.0, 3.0, 10.0, 3.0, LONGEST_LAG, 10.0, LONGEST_DELAY])[:n]
    none = np.inf
    deviations = np.array(
        [none, knowledge.stiffness_ratio, none, knowledge.damping_ratio, none, knowledge.spread, none]
    )[:n]
    centre = np.zeros(n)
    centre[5] = knowledge.interpolations
    return Form(response, denominator, 4, lower, upper, centre, deviations)


def contact_starts(believed: Mapping[str, float], knowledge: Knowledge, *, with_delay: bool) -> list[Floats]:
    """Return theta of what is believed, and of stiffer and softer contacts: a mode is found from near."""
    late = [0.0] if with_delay else []
    return [
        np.array([np.log(factor), 0.0, 0.0, 0.0, max(believed["T_f"], 1e-3), knowledge.interpolations, *late])
        for factor in (1.0, 0.7, 0.85, 1.15, 1.35)
    ]


def contact_start(believed: Mapping[str, float]) -> Floats:
    """Return k_m, k_p [N/m], c_m, c_p [N s/m] as they are believed."""
    return np.array([believed[name] for name in ("k_m", "k_p", "c_m", "c_p")])


def attributes(theta: Floats, believed: Floats) -> Floats:
    """Return k_m, k_p [N/m], c_m, c_p [N s/m] of a contact's theta."""
    stiffer, stiffness_split, damped, damping_split = theta[:4]
    logs = [
        stiffer + 0.5 * stiffness_split,
        stiffer - 0.5 * stiffness_split,
        damped + 0.5 * damping_split,
        damped - 0.5 * damping_split,
    ]
    return np.asarray(believed * np.exp(logs))


def series_stiffness(contact: Floats) -> float:
    """Return k [N/m] of k_m, k_p, c_m, c_p."""
    k_m, k_p = contact[:2]
    return float(k_m * k_p / (k_m + k_p))


def series_damping(contact: Floats) -> float:
    """Return c = k t_s [N s/m] of k_m, k_p, c_m, c_p."""
    k_m, k_p, c_m, c_p = contact
    return series_stiffness(contact) * float(c_m / k_m + c_p / k_p - (c_m + c_p) / (k_m + k_p))


def plant_lag(theta: Floats) -> float:
    """Return the lag of the motion simulator at rest [s], dead time included."""
    return float(np.exp(-theta[0]) + theta[3])
