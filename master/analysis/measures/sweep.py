"""
Stability over one or two parameters; the boundary by root search on the growth of the fastest pole.

An axis is `signals=from:to:n`: one parameter, or several joined by commas that get the same value. A
connected input in place of a parameter stands for an extra delay [s] of its connection; its boundary is
the delay margin.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from master.analysis.closed_loop.linearise import Linearisation
from master.errors import ConfigError, expected
from master.fmi.description import Kind
from master.system.graph import System, Wire

from .margins import margin
from .poles import growth_rate

Floats = NDArray[np.float64]
Progress = Callable[[], None]

_RELATIVE_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Axis:
    """Signals that get the same value, and the values."""

    signals: tuple[str, ...]
    values: Floats
    unit: str
    wire: Wire | None

    @property
    def label(self) -> str:
        """Text for people."""
        what = (
            f"delay of {self.wire.source.name} -> {self.wire.target.name}" if self.wire else self.signals[0]
        )
        return f"{what} [{self.unit}]"


@dataclass(frozen=True)
class StabilityMap:
    """
    Growth of the fastest pole [1/s], shape (len(y) or 1, len(x)), and its roots.

    Along a delay `growth` is that without delay, and NaN beyond the margin. `boundary` has a point (x, y)
    for each root, y = 0 without a second axis.
    """

    x: Axis
    y: Axis | None
    growth: Floats
    boundary: tuple[tuple[float, float], ...]

    @property
    def at_rest(self) -> list[float]:
        """Along a delay: growth of each column without it."""
        found: list[float] = np.nan_to_num(self.growth[0], nan=-1.0).tolist()
        return found


def parse_axis(text: str, system: System) -> Axis:
    """
    Read an axis.

    Raises:
        ConfigError: With what is wrong.
    """
    names, equals, span = text.partition("=")
    signals = tuple(s.strip() for s in names.split(","))
    faults = [] if equals else [f"--sweep: not an axis, got {text!r}, expected fmu.parameter=from:to:n"]
    values = _values(span, faults) if equals else np.zeros(0)
    wires = [w for w in system.wires if w.target.name == signals[0]]
    if wires and len(signals) == 1 and not faults:
        return Axis(signals, values, "s", wires[0])
    units = [_unit(system, s, faults) for s in signals] if equals else []
    if faults:
        raise ConfigError(faults)
    return Axis(signals, values, units[0], None)


def _values(span: str, faults: list[str]) -> Floats:
    try:
        first, last, n = span.split(":")
        if int(n) < 2 or not np.isfinite([float(first), float(last)]).all():
            raise ValueError
        return np.linspace(float(first), float(last), int(n))
    except ValueError:
        faults.append(f"--sweep: not a range, got {span!r}, expected from:to:n with n of at least 2")
        return np.zeros(0)


def _unit(system: System, signal: str, faults: list[str]) -> str:
    parameters = [
        f"{name}.{v.name}"
        for name, instance in system.instances.items()
        for v in instance.description.variables
        if v.causality == "parameter" and v.kind is Kind.REAL
    ]
    if signal not in parameters:
        faults.append(
            f"--sweep: no such parameter or connected input, got {signal!r}, {expected(signal, parameters)}"
        )
        return ""
    return system.port(signal).variable.unit_name


def stability_map(
    linearisation: Linearisation, x: Axis, y: Axis | None = None, progress: Progress = lambda: None
) -> StabilityMap:
    """Compute growth and boundary; `progress` is called for each value of x."""
    if x.wire is not None and y is not None:
        x, y = y, x
    if x.wire is not None:
        raise ConfigError([f"--sweep: a delay alone, got {x.label}, expected a parameter beside it"])
    columns, boundary = [], []
    for value in x.values:
        fixed = dict.fromkeys(x.signals, float(value))
        column, roots = _column(linearisation, fixed, y)
        columns.append(column)
        boundary += [(float(value), root) for root in roots]
        progress()
    growth = np.array(columns).T
    if y is None:
        boundary = [
            (root, 0.0) for root in _roots(_growth_along(linearisation, {}, x.signals), x.values, growth[0])
        ]
    return StabilityMap(x, y, growth, tuple(boundary))


def _column(
    linearisation: Linearisation, fixed: Mapping[str, float], y: Axis | None
) -> tuple[Floats, list[float]]:
    if y is None:
        return np.array([_growth_along(linearisation, fixed, ())(0.0)]), []
    if y.wire is not None:
        return _delays(linearisation, fixed, y, y.wire)
    function = _growth_along(linearisation, fixed, y.signals)
    column = np.array([function(float(v)) for v in y.values])
    return column, _roots(function, y.values, column)


def _delays(
    linearisation: Linearisation, fixed: Mapping[str, float], y: Axis, wire: Wire
) -> tuple[Floats, list[float]]:
    coupled = linearisation.coupled(fixed)
    if coupled.period != 1:
        raise ConfigError(["--sweep: no delay over FMUs of several rates, expected each to step every tick"])
    at_rest = growth_rate(coupled)
    if at_rest > 0.0:
        return np.full(len(y.values), at_rest), []
    bound = margin(coupled, wire).delay
    column = np.where(y.values < (np.inf if bound is None else bound), at_rest, np.nan)
    return column, [] if bound is None or bound > y.values[-1] else [bound]


def _growth_along(
    linearisation: Linearisation, fixed: Mapping[str, float], signals: Sequence[str]
) -> Callable[[float], float]:
    return lambda value: growth_rate(linearisation.coupled({**fixed, **dict.fromkeys(signals, value)}))


def _roots(function: Callable[[float], float], values: Floats, growth: Floats) -> list[float]:
    places = np.flatnonzero(np.sign(growth[:-1]) * np.sign(growth[1:]) < 0)
    tolerance = _RELATIVE_TOLERANCE * float(np.ptp(values))
    return [float(brentq(function, values[i], values[i + 1], xtol=tolerance)) for i in places]
