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
    unstable = np.where(np.isnan(found.growth), 1.0, (found.growth > 0.0).astype(float))
    axis.contourf(
        found.x.values, found.y.values, unstable, levels=[-0.5, 0.5, 1.5], colors=[_STABLE, _UNSTABLE]
    )
    if found.boundary:
        x, y = np.array(found.boundary).T
        axis.plot(x, y, "o-" if len(set(x)) == len(x) else "o", color=_LINE, markersize=3)
    axis.set_ylabel(found.y.label)
    axis.text(
        0.02, 0.98, "green: stable, red: unstable", transform=axis.transAxes, va="top", fontsize="small"
    )
