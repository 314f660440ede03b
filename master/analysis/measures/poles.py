"""Poles of the coupled system: frequency, damping, growth, and which FMUs participate."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, eigvals

from master.analysis.closed_loop.tick_matrix import LinearSystem
from master.analysis.state_space import StateSpace
from master.text.signal_name import SignalName

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

SMALLEST_MODULUS = 1e-3
_SHOWN_SHARE = 0.02


@dataclass(frozen=True)
class Pole:
    """
    A pole z of one period [s] of the order, s = log(z)/period [1/s].

    `parts` gives the share of each FMU (or value under way) that participates, largest first; `weight` the
    energy of the pole in the compared signal after a push on the inputs of that signal's FMU.
    """

    z: complex
    period: float
    parts: tuple[tuple[str, float], ...] = ()
    weight: float = 0.0

    @property
    def s(self) -> complex:
        """Continuous pole [1/s]."""
        return cmath.log(self.z) / self.period

    @property
    def frequency(self) -> float:
        """Frequency of the damped oscillation [Hz]."""
        return abs(self.s.imag) / (2.0 * math.pi)

    @property
    def zeta(self) -> float:
        """Damping ratio -Re(s)/|s|; 0 for a pole at z = 1."""
        return -self.s.real / abs(self.s) if abs(self.s) > 0.0 else 0.0

    @property
    def growth_per_cycle(self) -> float | None:
        """Ratio of amplitudes one cycle apart; None where nothing oscillates."""
        if not self.oscillates:
            return None
        return math.exp(min(700.0, 2.0 * math.pi * self.s.real / abs(self.s.imag)))

    @property
    def oscillates(self) -> bool:
        """Whether it is one of a conjugate pair."""
        return 1e-9 < abs(cmath.phase(self.z)) < math.pi - 1e-9


def poles(coupled: LinearSystem, signal: str | None = None, duration: float = 10.0) -> list[Pole]:
    """Return one pole for each conjugate pair, slowest decay first; `duration` [s] is for the weights."""
    modes = _modes(coupled.matrix())
    z = modes.z
    period = coupled.period * coupled.step_size
    found = []
    weights = _weights(coupled, signal, modes, duration)
    for i in np.argsort(-np.abs(z), kind="stable"):
        if z[i].imag >= 0.0 and abs(z[i]) > SMALLEST_MODULUS:
            parts = _participation(coupled.owners(), modes.left[:, i], modes.right[:, i])
            found.append(Pole(complex(z[i]), period, parts, weights[i]))
    return found


class _Modes(NamedTuple):
    """Eigenvalues, and eigenvectors as columns."""

    z: Complexes
    left: Complexes
    right: Complexes


def _modes(M: Floats) -> _Modes:
    found: Any = eig(M, left=True, right=True)
    return _Modes(*found)


def _participation(owners: Sequence[str], left: Complexes, right: Complexes) -> tuple[tuple[str, float], ...]:
    share = np.abs(left.conj() * right)
    total = float(np.sum(share)) or 1.0
    sums: dict[str, float] = {}
    for owner, value in zip(owners, share, strict=True):
        sums[owner] = sums.get(owner, 0.0) + float(value) / total
    ranked = sorted(sums.items(), key=lambda item: -item[1])
    return tuple((name, value) for name, value in ranked if value > _SHOWN_SHARE)


def _weights(coupled: LinearSystem, signal: str | None, modes: _Modes, duration: float) -> list[float]:
    z, left, right = modes
    instance = "" if signal is None else SignalName(signal).instance
    pushed = [w for w in coupled.wires if w.target.instance == instance]
    if signal is None or not pushed or coupled.period != 1:
        return [0.0] * len(z)
    c = coupled.row(signal)
    weights = np.zeros(len(z))
    n_steps = max(1, round(duration / coupled.step_size))
    for wire in pushed:
        b = coupled.opened(wire, cut=False).N[:, 0]
        overlap = np.sum(left.conj() * right, axis=0)
        residue = np.abs((c @ right) * (left.conj().T @ b)) / np.maximum(np.abs(overlap), 1e-300)
        weights += residue**2 * np.array([_energy(abs(v), n_steps) for v in z])
    return [float(w) if math.isfinite(w) else 0.0 for w in weights]


def _energy(modulus: float, n: int) -> float:
    """Sum of |z|^2k over n steps."""
    rate = 2.0 * math.log(max(modulus, 1e-300)) * n
    if abs(rate) < 1e-9:
        return float(n)
    return math.expm1(min(rate, 600.0)) / math.expm1(rate / n)


def dominant(found: Sequence[Pole]) -> Pole | None:
    """Oscillating pole of the largest weight; without weights the one that decays slowest."""
    oscillating = [p for p in found if p.oscillates]
    return max(oscillating, key=lambda p: (p.weight, abs(p.z)), default=None)


def nearest(system: StateSpace, step_size: float, to: Pole) -> Pole | None:
    """Pole of one FMU alone, nearest to a given one."""
    own = [Pole(complex(z), step_size) for z in eigvals(system.A) if abs(z) > SMALLEST_MODULUS]
    return min(own, key=lambda p: abs(p.s - complex(to.s.real, abs(to.s.imag))), default=None)


class Fastest(NamedTuple):
    """The pole that grows fastest: its growth log|z|/period [1/s], and its damping ratio -Re(s)/|s|."""

    growth: float
    zeta: float


def fastest(coupled: LinearSystem, neutral: float = 0.0) -> Fastest:
    """Find the pole that grows fastest; those nearer to z = 1 than `neutral` are left out."""
    z = np.linalg.eigvals(coupled.matrix())
    z = z[np.abs(z - 1.0) >= neutral]
    moduli = np.abs(z)
    if not np.any(moduli > 0.0):
        return Fastest(math.log(1e-300) / (coupled.period * coupled.step_size), 1.0)
    place = int(np.argmax(moduli))
    period = coupled.period * coupled.step_size
    return Fastest(math.log(max(float(moduli[place]), 1e-300)) / period, Pole(complex(z[place]), period).zeta)


def growth_rate(coupled: LinearSystem) -> float:
    """Largest growth of any pole [1/s]; above 0 the system is unstable."""
    return fastest(coupled).growth
