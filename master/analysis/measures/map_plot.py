"""Picture of a stability map."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .sweep import StabilityMap

_STABLE, _UNSTABLE, _LINE = "#d7ead9", "#f6d5d5", "#1f3a5f"


def plot_map(found: StabilityMap, title: str, path: Path) -> Path:
    """Draw growth over one parameter, or stable and unstable regions over two, as PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 5.0), layout="constrained")
    FigureCanvasAgg(figure)
    axis = figure.subplots()
    axis.set_title(title)
    axis.set_xlabel(found.x.label)
    if found.y is None:
        _curve(axis, found)
    else:
        _regions(axis, found)
    axis.grid(alpha=0.3)
    figure.savefig(path, dpi=120)
    return path


def _curve(axis: Any, found: StabilityMap) -> None:
    axis.plot(found.x.values, found.growth[0], color=_LINE)
    axis.axhline(0.0, color="0.3", linewidth=0.8)
    for x, _ in found.boundary:
        axis.plot(x, 0.0, "o", color="#d1495b")
        axis.annotate(f" {x:.4g}", (x, 0.0), va="bottom")
    axis.set_ylabel("growth of the fastest pole [1/s]")


def _regions(axis: Any, found: StabilityMap) -> None:
    assert found.y is not None
    if found.y.wire is None:
        colours, ends = [_STABLE, _UNSTABLE], float(np.max(np.abs(found.growth))) + 1.0
        axis.contourf(found.x.values, found.y.values, found.growth, levels=[-ends, 0.0, ends], colors=colours)
    else:
        _below_margin(axis, found)
    if found.boundary:
        x, y = np.array(found.boundary).T
        axis.plot(x, y, "o-" if len(set(x)) == len(x) else "o", color=_LINE, markersize=3)
    axis.set_ylabel(found.y.label)
    axis.text(
        0.02, 0.98, "green: stable, red: unstable", transform=axis.transAxes, va="top", fontsize="small"
    )


def _below_margin(axis: Any, found: StabilityMap) -> None:
    """Shade up to the margin of each column, all of a column without margin, nothing of an unstable one."""
    assert found.y is not None
    low, high = found.y.values[0], found.y.values[-1]
    margins = dict(found.boundary)
    ends = [margins.get(float(x), high) for x in found.x.values]
    stable = [end if growth <= 0.0 else low for end, growth in zip(ends, found.at_rest, strict=True)]
    axis.set_facecolor(_UNSTABLE)
    axis.fill_between(found.x.values, low, np.maximum(stable, low), color=_STABLE, linewidth=0.0)
    axis.set_xlim(found.x.values[0], found.x.values[-1])
    axis.set_ylim(low, high)
