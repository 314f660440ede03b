"""
White Gaussian noise from a generator whose state is six whole numbers, kept exactly in doubles.

    p1 = (1403580 s11 - 810728 s10) mod m1      m1 = 2^32 - 209
    p2 = (527612 s22 - 1370589 s20) mod m2      m2 = 2^32 - 22853
    U  = ((p1 - p2) mod m1)/(m1 + 1), m1 for 0, hence within (0, 1)
    n  = sqrt(-2 ln U1) cos(2 pi U2)

All products stay below 2^53, so every language with IEEE doubles gives the same numbers.
Source   MRG32k3a: L'Ecuyer, Operations Research 47 (1999) 159-164, Fig. I; Box, Muller, Annals of
         Mathematical Statistics 29 (1958) 610-611.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic

M1 = 4294967087.0
M2 = 4294944443.0
A12, A13 = 1403580.0, 810728.0
A21, A23 = 527612.0, 1370589.0
NORM = 2.328306549295727688e-10
N_GENERATOR = 6


def seeded(seed: Any, m: Arithmetic) -> tuple[Any, ...]:
    """Give the generator's state, shape (6,), for a whole number from 0 to 2^31 - 1."""
    numbers = []
    last = seed + 1.0
    for modulus in (M1, M1, M1, M2, M2, M2):
        last = _modulo(A12 * last, modulus, m)
        numbers.append(last)
    return tuple(numbers)


def normal(generator: tuple[Any, ...], m: Arithmetic) -> tuple[Any, tuple[Any, ...]]:
    """Draw a number of mean 0 and variance 1; give it and the next state."""
    u1, generator = uniform(generator, m)
    u2, generator = uniform(generator, m)
    return m.sqrt(-2.0 * m.log(u1)) * m.cos(2.0 * m.pi * u2), generator


def uniform(generator: tuple[Any, ...], m: Arithmetic) -> tuple[Any, tuple[Any, ...]]:
    """Draw a number within (0, 1); give it and the next state."""
    s10, s11, s12, s20, s21, s22 = generator
    p1 = _modulo(A12 * s11 - A13 * s10, M1, m)
    p2 = _modulo(A21 * s22 - A23 * s20, M2, m)
    difference = p1 - p2
    u = m.where(difference > 0.0, difference, difference + M1) * NORM
    return u, (s11, s12, p1, s21, s22, p2)


def _modulo(n: Any, modulus: float, m: Arithmetic) -> Any:
    rest = n - m.floor(n / modulus) * modulus
    return m.where(rest < 0.0, rest + modulus, rest)
