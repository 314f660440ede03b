"""
Stability over one or two parameters; the boundary by root search on the growth of the fastest pole.

An axis is `signals=from:to:n`: one parameter, or several joined by commas that get the same value. A
connected input in place of a parameter means an extra delay [s] of its connection; its boundary is
the delay margin.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from master.analysis.closed_loop.linearise import Linearisation
from master.errors import ConfigError, expected
from master.fmi.description import Kind
from master.system.graph import System, Wire

from .margins import margin
from .poles import fastest, growth_rate

Floats = NDArray[np.float64]
Progress = Callable[[], None]

_RELATIVE_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Axis:
    """
    Signals that get the same value, and the values.

    `own` is the value that the system itself has; None where its signals differ. That of a delay is 0.
    """

    signals: tuple[str, ...]
    values: Floats
    unit: str
    wire: Wire | None
    own: float | None = None

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
    Growth [1/s] and damping ratio of the fastest pole, shapes (len(y) or 1, len(x)), and the growth's roots.

    Along a delay both are those without delay, and NaN beyond the margin. `boundary` has a point (x, y) for
    each root, y = 0 without a second axis.
    """

    x: Axis
    y: Axis | None
    growth: Floats
    damping: Floats
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
        return Axis(signals, values, "s", wires[0], own=0.0)
    units = [_unit(system, s, faults) for s in signals] if equals else []
    if faults:
        raise ConfigError(faults)
    own = {float(_own_value(system, signal)) for signal in signals}
    return Axis(signals, values, units[0], None, own=own.pop() if len(own) == 1 else None)


def _own_value(system: System, signal: str) -> float | str:
    instance, _, name = signal.partition(".")
    return system.instances[instance].value_of(name) or 0.0


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
        raise ConfigError([f"--sweep: a delay alone, got {x.label}, expected a parameter with it"])
    columns = []
    boundary: list[tuple[float, float]] = []
    for value in x.values:
        column = _column(linearisation, dict.fromkeys(x.signals, float(value)), y)
        columns.append(column)
        boundary += [(float(value), root) for root in column.roots]
        progress()
    growth = np.array([column.growth for column in columns]).T
    damping = np.array([column.damping for column in columns]).T
    if y is None:
        boundary = [
            (root, 0.0) for root in _roots(_growth_along(linearisation, {}, x.signals), x.values, growth[0])
        ]
    elif y.wire is None:
        boundary += _along_x(linearisation, x, y, growth)
    return StabilityMap(x, y, growth, damping, tuple(sorted(boundary)))


def _along_x(linearisation: Linearisation, x: Axis, y: Axis, growth: Floats) -> list[tuple[float, float]]:
    """Find the roots between columns, which a boundary that runs along y has only."""
    found = []
    for value, row in zip(y.values, growth, strict=True):
        along = _growth_along(linearisation, dict.fromkeys(y.signals, float(value)), x.signals)
        found += [(root, float(value)) for root in _roots(along, x.values, row)]
    return found


class _Column(NamedTuple):
    """Growth and damping of the fastest pole along y, shapes (len(y) or 1,), and the roots of the growth."""

    growth: Floats
    damping: Floats
    roots: list[float]


def _column(linearisation: Linearisation, fixed: Mapping[str, float], y: Axis | None) -> _Column:
    if y is not None and y.wire is not None:
        return _delays(linearisation, fixed, y, y.wire)
    changes = [fixed] if y is None else [{**fixed, **dict.fromkeys(y.signals, float(v))} for v in y.values]
    found = [fastest(linearisation.coupled(change)) for change in changes]
    growth = np.array([one.growth for one in found])
    damping = np.array([one.zeta for one in found])
    if y is None:
        return _Column(growth, damping, [])
    along = _growth_along(linearisation, fixed, y.signals)
    return _Column(growth, damping, _roots(along, y.values, growth))


def _delays(linearisation: Linearisation, fixed: Mapping[str, float], y: Axis, wire: Wire) -> _Column:
    coupled = linearisation.coupled(fixed)
    if coupled.period != 1:
        raise ConfigError(["--sweep: no delay over FMUs of several rates, expected each to step every tick"])
    at_rest = fastest(coupled)
    if at_rest.growth > 0.0:
        return _Column(np.full(len(y.values), at_rest.growth), np.full(len(y.values), at_rest.zeta), [])
    bound = margin(coupled, wire).delay
    inside = y.values < (np.inf if bound is None else bound)
    return _Column(
        growth=np.where(inside, at_rest.growth, np.nan),
        damping=np.where(inside, at_rest.zeta, np.nan),
        roots=[] if bound is None or bound > y.values[-1] else [bound],
    )


def _growth_along(
    linearisation: Linearisation, fixed: Mapping[str, float], signals: Sequence[str]
) -> Callable[[float], float]:
    return lambda value: growth_rate(linearisation.coupled({**fixed, **dict.fromkeys(signals, value)}))


def _roots(function: Callable[[float], float], values: Floats, growth: Floats) -> list[float]:
    places = np.flatnonzero(np.sign(growth[:-1]) * np.sign(growth[1:]) < 0)
    tolerance = _RELATIVE_TOLERANCE * float(np.ptp(values))
    return [float(brentq(function, values[i], values[i + 1], xtol=tolerance)) for i in places]
