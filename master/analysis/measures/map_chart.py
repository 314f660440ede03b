"""
A stability map as a chart: blue where the system is stable, orange where it is not.

Shades, boundary and lines of equal damping come from one triangulation of the computed points, in which each
root of the growth is a point with growth 0: the line runs through the roots, and the shading changes at it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from master.pages.chart import CIRCLE, EVENT, Chart, Curve, Region

from .sweep import Floats, StabilityMap

BLUE, ORANGE = "#2f7fb8", "#d9751e"
OWN = "the system as it is"
BOUNDARY = "boundary of stability"
N_LEVELS = 5  # shades of either colour
MOST_CONTOURS = 7  # of damping
_LEAST_ALPHA, _MOST_ALPHA = 0.12, 0.62  # text and lines are seen over them on light and dark pages


class Points(NamedTuple):
    """Coordinates, growth [1/s] and damping ratio of points, shape (n,) each."""

    x: Floats
    y: Floats
    growth: Floats
    damping: Floats


def points(found: StabilityMap) -> Points:
    """Return all points of a map over two parameters; at the roots growth and damping are 0."""
    assert found.y is not None
    x, y = np.meshgrid(found.x.values, found.y.values)
    roots = np.array(found.boundary).reshape(-1, 2)
    is_new = np.array([not np.any((x == a) & (y == b)) for a, b in roots], dtype=bool)
    roots = roots[is_new]
    zero = np.zeros(len(roots))
    return Points(
        x=np.concatenate([x.ravel(), roots[:, 0]]),
        y=np.concatenate([y.ravel(), roots[:, 1]]),
        growth=np.concatenate([found.growth.ravel(), zero]),
        damping=np.concatenate([found.damping.ravel(), zero]),
    )


def mesh(found: StabilityMap, own: Points) -> Any:
    """Triangulate the points, whatever the units of the axes."""
    from matplotlib.tri import Triangulation

    assert found.y is not None
    spans = (np.ptp(found.x.values), np.ptp(found.y.values))
    triangles = Triangulation(own.x / spans[0], own.y / spans[1]).triangles
    return Triangulation(own.x, own.y, triangles)


def map_chart(found: StabilityMap, title: str, y_scale: float = 1.0, y_label: str = "") -> Chart:
    """
    Return the chart of a map over two parameters, or of the growth over one.

    Args:
        found: The map.
        title: Title of the chart.
        y_scale: Factor of the second axis, from its unit to that of its label.
        y_label: Label of the second axis; its own by default.
    """
    if found.y is None:
        return _growth_chart(found, title)
    y_label = y_label or found.y.label
    own = points(found)
    own = own._replace(y=y_scale * own.y)
    triangles = mesh(found, own)
    curves = []
    regions = [*_shades(triangles, own.growth), *_contours(triangles, own.damping)]
    if found.boundary:
        [line] = _lines(triangles, own.growth, [0.0])
        one = _as_function(line)
        if one is None:
            regions.append(replace(line, is_bold=True))
        else:
            curves.append(Curve(BOUNDARY, one.x, one.y))
    if _shows(found):
        place = np.array([found.x.own, y_scale * float(found.y.own or 0.0)])
        curves.append(Curve(OWN, place[:1], place[1:], CIRCLE))
    return Chart(
        title=title,
        x_label=found.x.label,
        y_label=y_label,
        curves=curves,
        x_range=(float(found.x.values.min()), float(found.x.values.max())),
        y_range=(float(own.y.min()), float(own.y.max())),
        regions=regions,
    )


def _growth_chart(found: StabilityMap, title: str) -> Chart:
    x = found.x.values
    low, high = float(found.growth.min()), float(found.growth.max())
    edges = np.array([x[0], x[-1], x[-1], x[0]])
    bands = [
        (colour, a, b)
        for colour, a, b in ((BLUE, low, min(high, 0.0)), (ORANGE, max(low, 0.0), high))
        if b > a
    ]
    regions = [Region(edges, np.array([a, a, b, b]), _rgba(colour, 0.3)) for colour, a, b in bands]
    curves = [Curve("growth of the fastest pole", x, found.growth[0])]
    if found.boundary:
        roots = np.array(found.boundary)
        curves.append(Curve(BOUNDARY, roots[:, 0], roots[:, 1], CIRCLE))
    if found.x.own is not None and x.min() <= found.x.own <= x.max():
        hair = 1e-6 * float(np.ptp(x))
        at = found.x.own if found.x.own + hair <= x.max() else found.x.own - hair
        curves.append(Curve(OWN, np.array([at, at + hair]), np.array([low, high]), EVENT))
    return Chart(title, found.x.label, "growth of the fastest pole [1/s]", curves, regions=regions)


def _shows(found: StabilityMap) -> bool:
    assert found.y is not None
    return all(
        axis.own is not None and axis.values.min() <= axis.own <= axis.values.max()
        for axis in (found.x, found.y)
    )


def _rgba(colour: str, alpha: float) -> str:
    return f"{colour}{round(255 * alpha):02x}"


def _shades(triangles: Any, growth: Floats) -> list[Region]:
    """Return bands of growth, darker the further from 0."""
    found = []
    alphas = np.linspace(_LEAST_ALPHA, _MOST_ALPHA, N_LEVELS)
    for colour, end in ((BLUE, float(growth.min())), (ORANGE, float(growth.max()))):
        if (end < 0.0) != (colour == BLUE) or end == 0.0:
            continue
        levels = np.linspace(0.0, end * (1.0 + 1e-9), N_LEVELS + 1)
        for first, second, alpha in zip(levels[:-1], levels[1:], alphas, strict=True):
            band = _filled(triangles, growth, min(first, second), max(first, second))
            if len(band.x):
                found.append(replace(band, fill=_rgba(colour, float(alpha))))
    return found


def _contours(triangles: Any, damping: Floats) -> list[Region]:
    from matplotlib.ticker import MaxNLocator

    if not np.ptp(damping) > 0.0:
        return []
    ticks = MaxNLocator(MOST_CONTOURS).tick_values(float(damping.min()), float(damping.max()))
    inside = (ticks > damping.min()) & (ticks < damping.max()) & (np.abs(ticks) > 1e-12)  # 0: the boundary
    levels = [float(level) for level in ticks[inside]]
    lines = _lines(triangles, damping, levels) if levels else []
    return [
        replace(line, label=f"{level:.3g}") for level, line in zip(levels, lines, strict=True) if len(line.x)
    ]


def _as_function(line: Region) -> Region | None:
    """Return a line in the order of x, if it is one line with one y for each x."""
    if np.isnan(line.x).any():
        return None
    x, y = (line.x, line.y) if line.x[-1] > line.x[0] else (line.x[::-1], line.y[::-1])
    return Region(x, y) if np.all(np.diff(x) > 0.0) else None


def _lines(triangles: Any, values: Floats, levels: Sequence[float]) -> list[Region]:
    """Return the lines of each level."""
    from matplotlib.figure import Figure

    found = Figure().subplots().tricontour(triangles, values, levels=levels)
    return [
        _pieces([np.asarray(piece, dtype=float) for piece in path.to_polygons(closed_only=False)])
        for path in found.get_paths()
    ]


def _filled(triangles: Any, values: Floats, low: float, high: float) -> Region:
    """Return the rings around what is between two values."""
    from matplotlib.figure import Figure

    found = Figure().subplots().tricontourf(triangles, values, levels=[low, high])
    return _pieces([np.asarray(piece, dtype=float) for piece in found.get_paths()[0].to_polygons()])


def _pieces(pieces: Sequence[Floats]) -> Region:
    """Put pieces of shape (n, 2) into one region, NaN between them."""
    gap = np.full((1, 2), np.nan)
    rows = [row for piece in pieces for row in (gap, piece)][1:]
    whole = np.concatenate(rows) if rows else np.empty((0, 2))
    return Region(whole[:, 0], whole[:, 1])
