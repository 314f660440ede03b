"""
Tuning of the identifiers: the two presets and the free one.

    preset   P0(a, b)  P0(c, d, e)  Q     R [N^2]  prefilter
    L        1e-2      1e6          0     1e-3     none       literal Kalman filter
    F        1e-2      1e-2         0     1e-3     5 Hz       prefilter and good prior
    custom   parameters P0_ab, P0_cde, Q_ab, Q_cde, R, prefilter_frequency

The prefilter is two equal low-passes of first order on f and on s_act - x, for identification only:

    y(k) = y(k-1) + (1 - exp(-2 pi frequency T)) (u(k) - y(k-1))
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

from ..framework.arithmetic import Arithmetic


class Preset(IntEnum):
    """Whose tuning the identifier takes."""

    custom = 1
    L = 2
    F = 3


class Tuning(NamedTuple):
    """Start covariance, process and measurement variance, cut-off frequency [Hz] (0 = no prefilter)."""

    P0_ab: Any
    P0_cde: Any
    Q_ab: Any
    Q_cde: Any
    R: Any
    prefilter_frequency: Any


L = Tuning(1e-2, 1e6, 0.0, 0.0, 1e-3, 0.0)
F = Tuning(1e-2, 1e-2, 0.0, 0.0, 1e-3, 5.0)


def tuning(p: Any, m: Arithmetic) -> Tuning:
    """Choose the tuning of the preset."""
    custom = Tuning(p.P0_ab, p.P0_cde, p.Q_ab, p.Q_cde, p.R, p.prefilter_frequency)
    return Tuning(*(m.pick(values, p.preset - 1) for values in zip(custom, L, F, strict=True)))


def prefilter_share(frequency: Any, T: Any, m: Arithmetic) -> Any:
    """Give the share of the new value that a low-pass takes in one period T [s]; 1 without prefilter."""
    return m.where(frequency > 0.0, 1.0 - m.exp(-2.0 * m.pi * frequency * T), 1.0)


def low_pass(stage: Any, last: Any, u: Any, share: Any) -> tuple[Any, Any]:
    """Step the two low-passes; give the state of the first and of the second, which is the output."""
    stage = stage + share * (u - stage)
    return stage, last + share * (stage - last)
