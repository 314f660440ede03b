"""Pictures of a run: displacement and force against the reference, units on the axes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from master.recording.recorder import Result
from master.system.config import Compare

_REFERENCE = {"color": "0.15", "linewidth": 2.6, "alpha": 0.45}
_COLOURS = ("#0b6fb8", "#d1495b")


def plot_run(result: Result, compare: Compare, title: str, path: Path) -> Path:
    """Draw displacement, force (where the configuration names one) and deviation over time as PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    panels = [_displacement, _force, _deviation]
    if compare.force is None:
        panels.remove(_force)
    if compare.reference is None:
        panels.remove(_deviation)
    figure = Figure(figsize=(9.0, 2.6 * len(panels) + 0.6), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    axes = np.atleast_1d(figure.subplots(len(panels), 1, sharex=True))
    for axis, draw in zip(axes, panels, strict=True):
        draw(axis, result, compare)
        axis.grid(alpha=0.3)
        axis.margins(x=0.0)
        axis.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, frameon=False, fontsize="small")
    axes[-1].set_xlabel("time [s]")
    figure.savefig(path, dpi=120)
    return path


def _displacement(axis: Any, result: Result, compare: Compare) -> None:
    scale, unit = _length_scale(result, compare)
    if compare.reference is not None:
        axis.plot(result.time, scale * result[compare.reference], label=compare.reference, **_REFERENCE)
    motions = [s for s in (compare.signal, compare.reproduced) if s is not None]
    for colour, name in zip(_COLOURS, motions, strict=False):
        axis.plot(result.time, scale * result[name], label=name, color=colour, linewidth=1.1)
    axis.set_ylabel(f"displacement [{unit}]")


def _force(axis: Any, result: Result, compare: Compare) -> None:
    assert compare.force is not None
    if compare.reference_force is not None:
        reference = result[compare.reference_force]
        axis.plot(result.time, reference, label=compare.reference_force, **_REFERENCE)
    axis.plot(result.time, result[compare.force], label=compare.force, color=_COLOURS[0], linewidth=1.1)
    axis.set_ylabel(f"force [{result.unit(compare.force)}]")


def _deviation(axis: Any, result: Result, compare: Compare) -> None:
    assert compare.reference is not None
    scale, unit = _length_scale(result, compare)
    motions = [s for s in (compare.signal, compare.reproduced) if s is not None]
    for colour, name in zip(_COLOURS, motions, strict=False):
        deviation = scale * (result[name] - result[compare.reference])
        axis.plot(result.time, deviation, label=f"{name} - reference", color=colour, linewidth=1.1)
    axis.set_ylabel(f"deviation [{unit}]")


def _length_scale(result: Result, compare: Compare) -> tuple[float, str]:
    """Millimetres for small motions in metres, otherwise the signal's own unit."""
    unit = result.unit(compare.signal)
    small = unit == "m" and np.max(np.abs(result[compare.signal])) < 1.0
    return (1e3, "mm") if small else (1.0, unit)
