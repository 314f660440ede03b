"""Charts of motions that are compared: displacement and force against the reference, units on the axes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from master.pages.chart import REFERENCE, Chart, Curve
from master.recording.recorder import Result
from master.system.config import Compare

Floats = NDArray[np.float64]

TIME = "time [s]"
MILLIMETRES = "[mm]"


def charts(result: Result, compare: Compare) -> list[Chart]:
    """Return the charts of a run that has motions to compare."""
    found = [_displacement(result, compare)]
    if compare.force is not None:
        found.append(_force(result, compare.force, compare.reference_force))
    if compare.reference is not None:
        found.append(_deviation(result, compare, compare.reference))
    return found


def _displacement(result: Result, compare: Compare) -> Chart:
    scale, unit = _length_scale(result, compare)
    curves = [Curve(name, result.time, scale * result[name]) for name in _motions(compare)]
    if compare.reference is not None:
        name = compare.reference
        curves.insert(0, Curve(name, result.time, scale * result[name], REFERENCE))
    return Chart("", TIME, f"displacement [{unit}]", curves)


def _force(result: Result, force: str, reference: str | None) -> Chart:
    curves = [Curve(force, result.time, result[force])]
    if reference is not None:
        curves.insert(0, Curve(reference, result.time, result[reference], REFERENCE))
    return Chart("", TIME, f"force [{result.unit(force)}]", curves)


def _deviation(result: Result, compare: Compare, reference: str) -> Chart:
    scale, unit = _length_scale(result, compare)
    curves = [
        Curve(f"{name} - reference", result.time, scale * (result[name] - result[reference]))
        for name in _motions(compare)
    ]
    return Chart("", TIME, f"deviation [{unit}]", curves)


def _motions(compare: Compare) -> list[str]:
    return [name for name in (compare.signal, compare.reproduced) if name is not None]


def _length_scale(result: Result, compare: Compare) -> tuple[float, str]:
    """Millimetres for small motions in metres, otherwise the signal's own unit."""
    unit = result.unit(compare.signal)
    small = unit == "m" and np.max(np.abs(result[compare.signal])) < 1.0
    return (1e3, "mm") if small else (1.0, unit)
