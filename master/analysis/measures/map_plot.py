"""
Picture of a stability map: blue where the system is stable, orange where it is not.

Shading, boundary and lines of equal damping come from one triangulation of the computed points, in which each
root of the growth is a point with growth 0: the line runs through the roots, and the shading changes at it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from master.pages.palette import LIGHT
from master.pages.plain_text import as_written

from .sweep import Floats, StabilityMap

_BLUE, _MIDDLE, _ORANGE = "#2f7fb8", "#f4f4f4", "#d9751e"
_STABLE, _UNSTABLE = "#bfd9ea", "#f6d3b3"
_LINE = LIGHT[4]
_N_LEVELS = 8


def plot_map(found: StabilityMap, title: str, path: Path) -> Path:
    """Draw growth over one parameter, or growth and damping over two, as PNG."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.4, 5.2), layout="constrained")
    axis = figure.subplots()
    axis.set_title(title)
    axis.set_xlabel(found.x.label)
    if found.y is None:
        _curve(axis, found)
    elif found.y.wire is None:
        _regions(figure, axis, found)
    else:
        _below_margin(axis, found)
    handles, labels = axis.get_legend_handles_labels()
    if labels:
        figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False, fontsize="small")
    as_written(figure).savefig(path, dpi=120)
    return path


def _curve(axis: Any, found: StabilityMap) -> None:
    axis.plot(found.x.values, found.growth[0], color=LIGHT[0])
    axis.axhline(0.0, color="0.3", linewidth=0.8)
    for x, _ in found.boundary:
        axis.plot(x, 0.0, "o", color=LIGHT[1])
        axis.annotate(f" {x:.4g}", (x, 0.0), va="bottom")
    if _is_inside(found.x.own, found.x.values):
        axis.axvline(found.x.own, color=_LINE, linestyle=":", label="the system as it is")
    axis.set_ylabel("growth of the fastest pole [1/s]")
    axis.grid(alpha=0.3)


def _regions(figure: Any, axis: Any, found: StabilityMap) -> None:
    from matplotlib.colors import LinearSegmentedColormap, TwoSlopeNorm
    from matplotlib.ticker import MaxNLocator
    from matplotlib.tri import Triangulation

    assert found.y is not None
    x, y, growth = points(found)
    spans = (np.ptp(found.x.values), np.ptp(found.y.values))
    triangles = Triangulation(x / spans[0], y / spans[1]).triangles
    mesh = Triangulation(x, y, triangles)
    low, high = min(float(growth.min()), -1e-9), max(float(growth.max()), 1e-9)
    colours = LinearSegmentedColormap.from_list("blue to orange", [_BLUE, _MIDDLE, _ORANGE])
    shades = np.concatenate([np.linspace(low, 0.0, _N_LEVELS), np.linspace(0.0, high, _N_LEVELS)[1:]])
    norm = TwoSlopeNorm(0.0, low, high)
    shading = axis.tricontourf(mesh, growth, levels=shades, cmap=colours, norm=norm)
    figure.colorbar(shading, ax=axis, label="growth of the fastest pole [1/s]", format="%.3g")
    if found.boundary:
        axis.tricontour(mesh, growth, levels=[0.0], colors=_LINE, linewidths=1.8)
        axis.plot([], [], color=_LINE, linewidth=1.8, label="boundary of stability")
    grid = np.meshgrid(found.x.values, found.y.values)
    if np.ptp(found.damping) > 0.0:
        ticks = MaxNLocator(7).tick_values(float(found.damping.min()), float(found.damping.max()))
        levels = [level for level in ticks if abs(level) > 1e-12]  # that of 0 is the boundary
        lines = axis.contour(
            *grid, found.damping, levels=levels, colors="0.35", linewidths=0.7, linestyles="--"
        )
        axis.clabel(lines, fmt="%.3g", fontsize="x-small")
        axis.plot([], [], color="0.35", linewidth=0.7, linestyle="--", label="damping ratio of that pole")
    _mark(axis, found)
    axis.set_ylabel(found.y.label)


class Points(NamedTuple):
    """Coordinates and growth [1/s] of points, shape (n,) each."""

    x: Floats
    y: Floats
    growth: Floats


def points(found: StabilityMap) -> Points:
    """Return all points of a map over two parameters, the roots with growth 0."""
    assert found.y is not None
    x, y = np.meshgrid(found.x.values, found.y.values)
    roots = np.array(found.boundary).reshape(-1, 2)
    is_new = np.array([not np.any((x == a) & (y == b)) for a, b in roots], dtype=bool)
    roots = roots[is_new]
    return Points(
        x=np.concatenate([x.ravel(), roots[:, 0]]),
        y=np.concatenate([y.ravel(), roots[:, 1]]),
        growth=np.concatenate([found.growth.ravel(), np.zeros(len(roots))]),
    )


def _below_margin(axis: Any, found: StabilityMap) -> None:
    """Shade up to the margin of each column, all of a column without margin, nothing of an unstable one."""
    assert found.y is not None
    low, high = found.y.values[0], found.y.values[-1]
    margins = dict(found.boundary)
    ends = [margins.get(float(x), high) for x in found.x.values]
    edge = [end if growth <= 0.0 else low for end, growth in zip(ends, found.at_rest, strict=True)]
    edge = np.maximum(edge, low)
    axis.set_facecolor(_UNSTABLE)
    axis.fill_between(found.x.values, low, edge, color=_STABLE, linewidth=0.0, label="stable")
    axis.fill_between([], [], color=_UNSTABLE, label="unstable")
    if found.boundary:
        axis.plot(found.x.values, edge, "o-", color=_LINE, markersize=3, label="boundary of stability")
    _mark(axis, found)
    axis.set_xlim(found.x.values[0], found.x.values[-1])
    axis.set_ylim(low, high)
    axis.set_ylabel(found.y.label)
    axis.grid(alpha=0.3)


def _mark(axis: Any, found: StabilityMap) -> None:
    """Mark the system as it is, where the map shows it."""
    assert found.y is not None
    if _is_inside(found.x.own, found.x.values) and _is_inside(found.y.own, found.y.values):
        axis.plot(
            found.x.own,
            found.y.own,
            marker="*",
            linestyle="none",
            markersize=13,
            color="#ffffff",
            markeredgecolor=_LINE,
            clip_on=False,
            label="the system as it is",
        )


def _is_inside(own: float | None, values: Any) -> bool:
    return own is not None and bool(np.min(values) <= own <= np.max(values))
