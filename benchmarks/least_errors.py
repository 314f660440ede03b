"""
The least error that white noise leaves in a docking, whatever the method: the table in docs/compensators.md.

    python benchmarks/least_errors.py [--seeds 2000]

A method that is to follow the ideal docking has to know the contact, and learns it from force and motion as
they are measured. With a share kappa of the stiffness and a share delta of the damping unknown,

    f_mea - f_model(s_act) = h kappa + g delta + n,      n white: the noise of the force, or k that of s_act

the motion at t is s + ds/dkappa kappa + ds/ddelta delta, and the least mean square error of a method that
sees the past alone is that of the conditional mean of kappa and delta (Gauss-Markov; the Cramer-Rao bound
where the prior is wide), with deviations of PRIOR before the run. The sensitivities are differences of the
ideal docking and of its contact, solved exactly; the sensor's lag, 0.1 % at these frequencies, is left out.
Unknown are

    stiffness            kappa, constant
    stiffness, damping   kappa and delta, constant
    the force itself     no model is believed: what is measured is passed on, noise and all
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.signal import lfilter, lsim, ss2tf

from master.comparison.systems import Base
from master.installation import configuration

Array = NDArray[np.float64]

T = 1e-3
"""Sampling period [s]."""
DURATION = 10.0
START = -0.01
"""Displacement at rest from which the docking starts [m]."""
PRIOR = 0.2
"""Deviation of kappa and of delta before the run [1]."""
STEP = 1e-4
"""Change of a share for a difference quotient."""
WITHIN = 5
"""Seeds of a choice."""


@dataclass(frozen=True)
class Case:
    """A configuration with a noise, the bound [%] of s_des and s_act, and s_act [%] without noise."""

    name: str
    config: str
    force_noise: float
    encoder_noise: float
    bound: float
    floor: float


CASES = (
    Case("S1, 5 N", "low_frequency", 5.0, 0.0, 1.0, 0.03),
    Case("S2, 5 N", "high_frequency", 5.0, 0.0, 0.5, 0.23),
    Case("E1, 5 N", "experiment", 5.0, 0.0, 1.2, 0.01),
    Case("E2, 5 N", "experiment_1000kg", 5.0, 0.0, 2.2, 0.02),
    Case("S1, 20 um", "low_frequency", 0.0, 2e-5, 0.4, 0.03),
    Case("S2, 20 um", "high_frequency", 0.0, 2e-5, 0.4, 0.23),
    Case("E1, 20 um", "experiment", 0.0, 2e-5, 0.4, 0.01),
    Case("E2, 20 um", "experiment_1000kg", 0.0, 2e-5, 0.4, 0.02),
)


@dataclass(frozen=True)
class Contact:
    """Docking of two bodies, `real_docking` without drag."""

    m_s: float
    m_e: float
    k_m: float
    c_m: float
    k_p: float
    c_p: float

    def changed(self, kappa: float, delta: float) -> Contact:
        """Return it with other shares of stiffness and damping."""
        k, c = 1.0 + kappa, 1.0 + delta
        return Contact(self.m_s, self.m_e, k * self.k_m, c * self.c_m, k * self.k_p, c * self.c_p)

    @property
    def stiffness(self) -> float:
        """Stiffness of rope and manipulator in series [N/m]."""
        return self.k_m * self.k_p / (self.k_m + self.k_p)

    def matrix(self) -> Array:
        """Return the matrix of the free docking with the states s, s', x_e, x_e'."""
        K = self.k_m + self.k_p
        C = self.c_m + self.c_p
        return np.array(
            [
                [0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, -self.k_m / self.m_s, -self.c_m / self.m_s],
                [0.0, 0.0, 0.0, 1.0],
                [self.k_p / self.m_e, self.c_p / self.m_e, -K / self.m_e, -C / self.m_e],
            ]
        )

    def motion(self) -> Array:
        """Return s and s' at the ticks, shape (n, 2)."""
        step = expm(self.matrix() * T)
        state = START * np.array([1.0, 0.0, self.k_p / (self.k_m + self.k_p), 0.0])
        rows = np.empty((round(DURATION / T), 2))
        for k in range(len(rows)):
            rows[k] = state[:2]
            state = step @ state
        return rows

    def force(self, motion: Array) -> Array:
        """Return the force [N] of the contact at the ticks where its motion is given."""
        A = self.matrix()
        time = T * np.arange(len(motion))
        start = motion[0, 0] * np.array([self.k_p / (self.k_m + self.k_p), 0.0])
        out = np.array([[-self.k_m, -self.c_m]])
        _, f, _ = lsim((A[2:, 2:], A[2:, :2], out, np.zeros((1, 2))), motion, time, X0=start)
        return np.asarray(f)


@dataclass(frozen=True)
class Sensitivities:
    """Of the ideal motion [m], and of the force [N] where the motion is given; shape (n, 2): kappa, delta."""

    ideal: Array
    of_motion: Array
    of_force: Array


def sensitivities(contact: Contact) -> Sensitivities:
    """Return difference quotients in kappa and delta."""
    motion = contact.motion()
    force = contact.force(motion)
    others = [contact.changed(STEP, 0.0), contact.changed(0.0, STEP)]
    of_motion = [(other.motion()[:, 0] - motion[:, 0]) / STEP for other in others]
    of_force = [(other.force(motion) - force) / STEP for other in others]
    return Sensitivities(motion[:, 0], np.transpose(of_motion), np.transpose(of_force))


def errors_of_constants(found: Sensitivities, noise: Array, sigma: float, n_unknown: int) -> Array:
    """Return the error [m] of the motion at each tick, shape of the noise (seeds, n), with 1 or 2 unknown."""
    h = found.of_force[:, :n_unknown]
    information = np.cumsum(h[:, :, None] * h[:, None, :], axis=0) / sigma**2 + np.eye(n_unknown) / PRIOR**2
    weights = np.linalg.solve(information, found.of_motion[:, :n_unknown, None])[:, :, 0]
    return np.asarray(
        sum(weights[:, i] * np.cumsum(h[:, i] * noise, axis=1) for i in range(n_unknown)) / sigma**2
    )


def errors_of_nothing(contact: Contact, noise: Array) -> Array:
    """Return the error [m] of the motion where the noise of the force [N] moves the mass."""
    A = np.zeros((5, 5))
    A[:4, :4] = contact.matrix()
    A[1, 4] = 1.0 / contact.m_s
    step = expm(A * T)
    numerator, denominator = ss2tf(step[:4, :4], step[:4, 4:], np.eye(4)[:1], np.zeros((1, 1)))
    return np.asarray(lfilter(numerator[0], denominator, noise, axis=1))


def main() -> None:
    """Print the table."""
    asked = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    asked.add_argument("--seeds", type=int, default=2000)
    given = asked.parse_args()
    print("| case | unknown | rms | median | 90 % | one seed above | five seeds all within |")
    print("|---|---|---|---|---|---|---|")
    for case in CASES:
        base = Base(configuration(case.config))
        names = {"m_e", "k_m", "c_m", "k_p", "c_p"}
        m_s = base.value(base.spacecraft, "m_s")
        contact = Contact(m_s=m_s, **{n: base.value(base.compensator, n) for n in names})
        sigma = case.force_noise + contact.stiffness * case.encoder_noise
        for unknown, found in _nrmse(contact, sigma, given.seeds).items():
            print(f"| {case.name} | {unknown} | {_numbers(found, case)} |", flush=True)


def _nrmse(contact: Contact, sigma: float, n_seeds: int) -> dict[str, Array]:
    """Return the NRMSE [%] of each seed by what is unknown."""
    known = sensitivities(contact)
    scale = 1e2 / np.sqrt(np.mean(known.ideal**2))
    ways: dict[str, Callable[[Array], Array]] = {
        "stiffness": lambda noise: errors_of_constants(known, noise, sigma, 1),
        "stiffness, damping": lambda noise: errors_of_constants(known, noise, sigma, 2),
        "the force itself": lambda noise: errors_of_nothing(contact, noise),
    }
    rng = np.random.default_rng(1)
    found: dict[str, list[Array]] = {name: [] for name in ways}
    for n in np.diff([*range(0, n_seeds, 100), n_seeds]):
        noise = sigma * rng.normal(size=(n, len(known.ideal)))
        for name, errors in ways.items():
            found[name].append(scale * np.sqrt(np.mean(errors(noise) ** 2, axis=1)))
    return {name: np.concatenate(parts) for name, parts in found.items()}


def _numbers(found: Array, case: Case) -> str:
    s_act = np.hypot(found, case.floor)
    above = float(np.mean(s_act > case.bound))
    rms = np.sqrt(np.mean(found**2))
    median, most = np.quantile(found, (0.5, 0.9))
    within = (1.0 - above) ** WITHIN
    return f"{rms:.2f} | {median:.2f} | {most:.2f} | {1e2 * above:.1f} % | {1e2 * within:.0f} %"


if __name__ == "__main__":
    main()
