"""
Recursion of a least-squares estimate and its covariance, Y = (a, b, c, d, e), one measurement a period.

    H      = (f(k-1), f(k-2), -s(k), -s(k-1), -s(k-2)),   Z = f(k),   s = s_act - x              (20)
    P      = P/lambda + Q                                 before the measurement                 (21)
    S      = H P H' + R
    K      = P H'/S
    Y      = Y + K (Z - H Y)
    P      = P - K H P

P is symmetric and kept as its upper triangle, row by row: p11 p12 .. p15 p22 .. p55. What lambda, Q and R are
makes it one identifier or another; only one of them runs, hence they share one P.
Source   Paper, Sec. IV-B.2, Eqs. 19-21.
Deviation  Eq. 21 prints P(k|k-1) = P(k|k-1) + Q after the gain; it is P(k-1|k-1) + Q before it. Q belongs
           to the process and R to the measurement, the reverse of the text. The minus on s makes the
           printed c, d, e (those of +G) right: the force is restoring.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ....framework.arithmetic import Arithmetic

N_COVARIANCE = 15
DIAGONAL = (0, 5, 9, 12, 14)


class Settings(NamedTuple):
    """Factor 1/lambda on P, variances that a period adds, variance of a measurement [N^2]."""

    inflation: Any
    Q_ab: Any
    Q_cde: Any
    R: Any


def diagonal(ab: Any, cde: Any) -> tuple[Any, ...]:
    """Return the packed matrix diag(ab, ab, cde, cde, cde)."""
    packed: list[Any] = [0.0] * N_COVARIANCE
    for place, value in zip(DIAGONAL, (ab, ab, cde, cde, cde), strict=True):
        packed[place] = value
    return tuple(packed)


def inflated(P: tuple[Any, ...], factor: Any) -> tuple[Any, ...]:
    """Return P/lambda, `factor` being 1/lambda."""
    return tuple(element * factor for element in P)


def predicted(P: tuple[Any, ...], Q_ab: Any, Q_cde: Any) -> tuple[Any, ...]:
    """Return P + Q, Q = diag(Q_ab, Q_ab, Q_cde, Q_cde, Q_cde)."""
    p11, p12, p13, p14, p15, p22, p23, p24, p25, p33, p34, p35, p44, p45, p55 = P
    return (
        *(p11 + Q_ab, p12, p13, p14, p15),
        *(p22 + Q_ab, p23, p24, p25),
        *(p33 + Q_cde, p34, p35),
        *(p44 + Q_cde, p45),
        p55 + Q_cde,
    )


def corrected(
    Y: tuple[Any, ...], P: tuple[Any, ...], H: tuple[Any, ...], Z: Any, R: Any, m: Arithmetic
) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Return Y and P after the measurement Z [N] of variance R [N^2]."""
    a, b, c, d, e = Y
    p11, p12, p13, p14, p15, p22, p23, p24, p25, p33, p34, p35, p44, p45, p55 = P
    h1, h2, h3, h4, h5 = H
    g1 = p11 * h1 + p12 * h2 + p13 * h3 + p14 * h4 + p15 * h5
    g2 = p12 * h1 + p22 * h2 + p23 * h3 + p24 * h4 + p25 * h5
    g3 = p13 * h1 + p23 * h2 + p33 * h3 + p34 * h4 + p35 * h5
    g4 = p14 * h1 + p24 * h2 + p34 * h3 + p44 * h4 + p45 * h5
    g5 = p15 * h1 + p25 * h2 + p35 * h3 + p45 * h4 + p55 * h5
    variance = h1 * g1 + h2 * g2 + h3 * g3 + h4 * g4 + h5 * g5
    S = m.where(variance > 0.0, variance, 0.0) + R
    k1, k2, k3, k4, k5 = g1 / S, g2 / S, g3 / S, g4 / S, g5 / S
    error = Z - (h1 * a + h2 * b + h3 * c + h4 * d + h5 * e)
    Y = (a + k1 * error, b + k2 * error, c + k3 * error, d + k4 * error, e + k5 * error)
    P = (
        *(p11 - k1 * g1, p12 - k1 * g2, p13 - k1 * g3, p14 - k1 * g4, p15 - k1 * g5),
        *(p22 - k2 * g2, p23 - k2 * g3, p24 - k2 * g4, p25 - k2 * g5),
        *(p33 - k3 * g3, p34 - k3 * g4, p35 - k3 * g5),
        *(p44 - k4 * g4, p45 - k4 * g5),
        p55 - k5 * g5,
    )
    return Y, P
