"""
Stability over one or two parameters; the boundary by root search on the growth of the fastest pole.

An axis is `signals=from:to:n`: one parameter, or several joined by commas that get the same value. A
connected input in place of a parameter means an extra delay [s] of its connection, whole steps or not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from master.analysis.closed_loop.linearise import Linearisation
from master.errors import ConfigError, expected
from master.fmi.description import Kind
from master.system.graph import System, Wire

from .delays import ExtraDelay, fastest_with_delays
from .poles import Fastest, fastest

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

    `boundary` has a point (x, y) for each root, y = 0 without a second axis.
    """

    x: Axis
    y: Axis | None
    growth: Floats
    damping: Floats
    boundary: tuple[tuple[float, float], ...]


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
    if y is not None and set(x.signals) & set(y.signals):
        raise ConfigError([f"--sweep: the same twice, got {x.label} and {y.label}, expected two axes"])
    if x.wire is not None and y is not None and y.wire is None:
        x, y = y, x
    point = _Point(linearisation, x, y)
    rows = [0.0] if y is None else y.values.tolist()
    growth = np.empty((len(rows), len(x.values)))
    damping = np.empty_like(growth)
    for i, a in enumerate(x.values.tolist()):
        for j, b in enumerate(rows):
            growth[j, i], damping[j, i] = point.fastest(a, b)
        progress()
    boundary = [
        (root, b) for j, b in enumerate(rows) for root in _roots(point.along_x(b), x.values, growth[j])
    ]
    if y is not None:
        boundary += [
            (a, root)
            for i, a in enumerate(x.values.tolist())
            for root in _roots(point.along_y(a), y.values, growth[:, i])
        ]
    return StabilityMap(x, y, growth, damping, tuple(sorted(boundary)))


@dataclass(frozen=True)
class _Point:
    """The fastest pole at values of the axes."""

    linearisation: Linearisation
    x: Axis
    y: Axis | None

    def fastest(self, a: float, b: float) -> Fastest:
        """Fastest pole where the first axis has a value and the second, if there is one, another."""
        changes: dict[str, float] = {}
        delays: list[ExtraDelay] = []
        for axis, value in ((self.x, a), (self.y, b)):
            if axis is None:
                continue
            if axis.wire is None:
                changes |= dict.fromkeys(axis.signals, value)
            else:
                delays.append(ExtraDelay(axis.wire, value))
        coupled = self.linearisation.coupled(changes)
        return fastest_with_delays(coupled, delays) if delays else fastest(coupled)

    def along_x(self, b: float) -> Callable[[float], float]:
        """Growth over the first axis, at a value of the second."""
        return lambda a: self.fastest(a, b).growth

    def along_y(self, a: float) -> Callable[[float], float]:
        """Growth over the second axis, at a value of the first."""
        return lambda b: self.fastest(a, b).growth


def _roots(function: Callable[[float], float], values: Floats, growth: Floats) -> list[float]:
    places = np.flatnonzero(np.sign(growth[:-1]) * np.sign(growth[1:]) < 0)
    tolerance = _RELATIVE_TOLERANCE * float(np.ptp(values))
    return [float(brentq(function, values[i], values[i + 1], xtol=tolerance)) for i in places]
