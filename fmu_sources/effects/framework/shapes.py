"""Shapes that several laws share, in scalar arithmetic."""

from __future__ import annotations

from typing import Any

from ...framework.arithmetic import Arithmetic


def clip(value: Any, low: Any, high: Any, m: Arithmetic) -> Any:
    """Keep a value between two limits."""
    return m.where(value < low, low, m.where(value > high, high, value))


def dead_zone(value: Any, half_width: Any, m: Arithmetic) -> Any:
    """What a value has beyond a gap of +- half_width around zero."""
    return value - clip(value, -half_width, half_width, m)


def smooth_sign(velocity: Any, smoothing: Any, m: Arithmetic) -> Any:
    """Sign of a velocity [m/s], rounded over +- smoothing [m/s] for the integrator: tanh(v / v_0)."""
    return m.tanh(velocity / smoothing)


def larger(a: Any, b: Any, m: Arithmetic) -> Any:
    """The larger of two."""
    return m.where(a > b, a, b)
