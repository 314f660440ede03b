"""
The contact model of second order as difference equation, by three difference methods, and back.

    G(s) = (k_m + c_m s)(k_p + c_p s)/(m_e s^2 + (c_m + c_p) s + k_m + k_p)                      (11)
    s    = (1 - q)/(T (h + (1 - h) q)),   q = one period of delay
           h = 1 backward, 1/2 bilinear, 0 forward
    G(q) = (c + d q + e q^2)/(1 - a q - b q^2)                                                   (15)

A polynomial p0 + p1 s + p2 s^2, times (T (h + (1 - h) q))^2, is with h' = 1 - h

    P0 = p0 T^2 h^2 + p1 T h + p2
    P1 = 2 p0 T^2 h h' + p1 T (h' - h) - 2 p2
    P2 = p0 T^2 h'^2 - p1 T h' + p2

For h = 1 this is Eq. 16 with b_t = -m_e/D0 (its printed numerator is its denominator).
Source   Paper, Sec. IV-B.1, Eqs. 11, 15, 16. The way back, `attributes`, is ours.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

from ..framework.arithmetic import Arithmetic

SMALLEST_DETERMINANT = 1e-9
DISCRIMINANT_TOLERANCE = 1e-9


class DifferenceMethod(IntEnum):
    """How a time derivative becomes a difference."""

    backward = 1
    forward = 2
    bilinear = 3


class Attributes(NamedTuple):
    """The five attribute parameters [kg, N/m, N s/m, N/m, N s/m]; `valid` unless singular or not physical."""

    m_e: Any
    k_m: Any
    c_m: Any
    k_p: Any
    c_p: Any
    valid: Any


def weight(method: Any, m: Arithmetic) -> Any:
    """Give h, the share of the new instant in the difference."""
    return m.pick((1.0, 0.0, 0.5), method - 1)


def discrete(polynomial: tuple[Any, Any, Any], h: Any, T: Any) -> tuple[Any, Any, Any]:
    """Turn coefficients of 1, s, s^2 into those of 1, q, q^2."""
    p0, p1, p2 = polynomial
    x0, x1, g = p0 * T * T, p1 * T, 1.0 - h
    return (
        x0 * h * h + x1 * h + p2,
        2.0 * x0 * h * g + x1 * (g - h) - 2.0 * p2,
        x0 * g * g - x1 * g + p2,
    )


def continuous(polynomial: tuple[Any, Any, Any], h: Any, T: Any) -> tuple[Any, Any, Any]:
    """Turn coefficients of 1, q, q^2 into those of 1, s, s^2."""
    P0, P1, P2 = polynomial
    x0 = P0 + P1 + P2
    x1 = P0 - P2 - x0 * (2.0 * h - 1.0)
    return x0 / (T * T), x1 / T, P0 - x0 * h * h - x1 * h


def process_parameters(p: Any, h: Any) -> tuple[Any, Any, Any, Any, Any]:
    """Give a, b [1] and c, d, e [N/m] of the assumed attribute parameters, Eq. 16."""
    T = p.sample_time
    numerator = (p.k_m * p.k_p, p.c_m * p.k_p + p.c_p * p.k_m, p.c_m * p.c_p)
    denominator = (p.k_m + p.k_p, p.c_m + p.c_p, p.m_e)
    N0, N1, N2 = discrete(numerator, h, T)
    D0, D1, D2 = discrete(denominator, h, T)
    return -D1 / D0, -D2 / D0, N0 / D0, N1 / D0, N2 / D0


def attributes(Y: tuple[Any, ...], h: Any, p: Any, m: Arithmetic) -> Attributes:
    """
    Recover the attribute parameters from a, b, c, d, e.

    The polynomials are known but for one common factor D0. With K = kappa D0, C = gamma D0,
    m_e = mu D0 and the numerator D0 (u + n s + q s^2), the splits of K and C must fit one another:

        (K^2/4 - u D0)(C^2/4 - q D0) = (K C/4 - n D0/2)^2
        D0 = (4 u q - n^2)/(kappa^2 q + gamma^2 u - kappa gamma n)

    The two elements can be exchanged; k_m - k_p takes the sign of the assumed values. Elements of equal
    c/k make 0/0: singular, all zero and not valid.
    """
    a, b, c, d, e = Y
    kappa, gamma, mu = continuous((1.0, -a, -b), h, p.sample_time)
    u, n, q = continuous((c, d, e), h, p.sample_time)
    top = 4.0 * u * q - n * n
    bottom = kappa * kappa * q + gamma * gamma * u - kappa * gamma * n
    regular = m.both(
        m.fabs(top) > SMALLEST_DETERMINANT * n * n,
        m.fabs(bottom) > SMALLEST_DETERMINANT * m.fabs(kappa * gamma * n),
    )
    D0 = m.where(regular, top / m.where(regular, bottom, 1.0), 0.0)
    return _split(D0, (kappa, gamma, mu), (u, n, q), p, m)


def _split(
    D0: Any, denominator: tuple[Any, ...], numerator: tuple[Any, ...], p: Any, m: Arithmetic
) -> Attributes:
    K, C, m_e = (m.where(D0 > 0.0, factor * D0, 0.0) for factor in denominator)
    U, N, Q = (m.where(D0 > 0.0, factor * D0, 0.0) for factor in numerator)
    k_square, c_square = 0.25 * K * K - U, 0.25 * C * C - Q
    k_half = m.sqrt(m.where(k_square > 0.0, k_square, 0.0)) * m.where(p.k_m >= p.k_p, 1.0, -1.0)
    c_half = m.sqrt(m.where(c_square > 0.0, c_square, 0.0))
    c_half = c_half * m.where((0.25 * K * C - 0.5 * N) * k_half >= 0.0, 1.0, -1.0)
    k_m, k_p = 0.5 * K + k_half, 0.5 * K - k_half
    c_m, c_p = 0.5 * C + c_half, 0.5 * C - c_half
    real = m.both(k_square >= -DISCRIMINANT_TOLERANCE * K * K, c_square >= -DISCRIMINANT_TOLERANCE * C * C)
    stiff = m.both(m_e > 0.0, m.both(k_m > 0.0, k_p > 0.0))
    damped = m.both(c_m >= 0.0, c_p >= 0.0)
    valid = m.both(D0 > 0.0, m.both(real, m.both(stiff, damped)))
    return Attributes(m_e, k_m, c_m, k_p, c_p, valid)
