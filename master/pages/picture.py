"""Charts as pictures: in the page, for paper and for browsers without scripts, and as PNG files."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .chart import (
    CIRCLE,
    COLUMNS,
    CROSS,
    EVENT,
    FEWEST_POINTS_OF_LABEL,
    MARKS,
    Chart,
    Region,
    decimated,
)
from .palette import LIGHT, LIGHT_REFERENCE, LIGHT_SOFT
from .plain_text import as_written

_MARKS: dict[str, dict[str, Any]] = {
    CROSS: {"marker": "x", "linestyle": "none", "markersize": 7},
    CIRCLE: {"marker": "o", "linestyle": "none", "markersize": 8, "fillstyle": "none"},
}
_CONTOUR: dict[str, Any] = {"color": LIGHT_SOFT, "linewidth": 0.7, "linestyle": "--"}
_WIDTH, _HEIGHT = 6.4, 3.0  # inch: on a phone its text is still 8 px high
_LEFT, _RIGHT, _BELOW, _ABOVE = 1.05, 0.12, 0.55, 0.12  # inch around its axes
_LINE = 0.22  # inch: of its title, of its labels
_LABELS_A_LINE = 2
_LEAST = 1.4  # inch: height of its axes, however many labels there are
_COLUMNS = 320  # two points a column are more than such a picture resolves
_PNG_DPI = 110
_PNG_WIDTH, _PNG_HEIGHT, _PNG_LINE = 10.0, 3.0, 0.3  # inch: of all, of a chart, of a line of the title
_PNG_LEFT, _PNG_RIGHT, _PNG_BELOW, _PNG_ABOVE = 1.0, 0.2, 0.55, 0.35  # inch around the axes of a chart
_PNG_LABEL, _PNG_MOST_LABELS = 0.18, 4.5  # inch: height of a label, most width of all
_POINTS = 0.6  # of a page's pixel, for dashes


def data_uri(chart: Chart) -> str:
    """Draw one chart as SVG, and return it as the address of an image in the page."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    figure = Figure(figsize=(_WIDTH, _HEIGHT))
    axis = figure.subplots()
    draw(axis, chart, _COLUMNS)
    legend(figure, axis, "lower center")
    below = _BELOW + _LINE * -(-len(axis.get_legend_handles_labels()[1]) // _LABELS_A_LINE)
    above = _ABOVE + _LINE * (1 + chart.title.count("\n"))
    height = max(_HEIGHT, below + _LEAST + above)
    figure.set_figheight(height)
    figure.subplots_adjust(
        left=_LEFT / _WIDTH, right=1.0 - _RIGHT / _WIDTH, bottom=below / height, top=1.0 - above / height
    )
    buffer = io.BytesIO()
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "dockloop"}):
        as_written(figure).savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return f"data:image/svg+xml;base64,{base64.b64encode(buffer.getvalue()).decode()}"


def save(title: str, charts: Sequence[Chart], path: Path) -> Path:
    """Draw charts one below the other, as a PNG file."""
    from matplotlib.figure import Figure

    above = _PNG_LINE * (1 + title.count("\n"))
    heights = [_height(chart) for chart in charts]
    figure = Figure(figsize=(_PNG_WIDTH, above + sum(heights)), dpi=_PNG_DPI)
    axes = figure.subplots(len(charts), 1, squeeze=False)[:, 0].tolist()
    for axis, chart in zip(axes, charts, strict=True):
        draw(axis, chart)
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize="small")
    figure.suptitle(title, y=1.0 - 0.1 / figure.get_figheight(), va="top")
    as_written(figure)
    _lay_out(figure, axes, heights)
    new = path.with_name(f".{path.name}.new")  # under its own name it is complete, or it is not there
    try:
        figure.savefig(new, format="png", dpi=_PNG_DPI)
        new.replace(path)
    finally:
        new.unlink(missing_ok=True)
    return path


def _height(chart: Chart) -> float:
    """Return how high [inch] a chart is: higher where it has many labels."""
    return max(_PNG_HEIGHT, _PNG_BELOW + _PNG_ABOVE + _PNG_LABEL * (1 + len(chart.curves)))


def _lay_out(figure: Any, axes: Sequence[Any], heights: Sequence[float]) -> None:
    """
    Place axes of heights [inch] one below the other, with room for their texts.

    Matplotlib's own layouts measure each number at the axes, which takes as long as to draw. The width of
    labels alone is not known before: they get what they need on the right, up to a bound.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas: Any = FigureCanvasAgg(figure)
    renderer = canvas.get_renderer()
    labels = [axis.get_legend().get_window_extent(renderer).width / figure.dpi for axis in axes]
    right = min(_PNG_RIGHT + max([0.0, *labels]), _PNG_MOST_LABELS)
    width, height = figure.get_size_inches()
    bottom = sum(heights)
    for axis, own in zip(axes, heights, strict=True):
        bottom -= own
        size = (width - _PNG_LEFT - right, own - _PNG_BELOW - _PNG_ABOVE)
        place = (_PNG_LEFT, bottom + _PNG_BELOW)
        axis.set_position((place[0] / width, place[1] / height, size[0] / width, size[1] / height))


def draw(axis: Any, chart: Chart, columns: int = COLUMNS) -> None:
    """Draw a chart into matplotlib's axes, with the extremes of a number of columns."""
    for region in chart.regions:
        _draw_region(axis, region)
    drawn = [decimated(curve, columns) for curve in chart.curves]
    for curve, look in zip(drawn, chart.looks, strict=True):
        style: dict[str, Any] = {"color": LIGHT_REFERENCE, "linewidth": 3.0, "zorder": 1.5}
        if curve.style == EVENT:
            style = {"color": LIGHT_SOFT, "linewidth": 0.8, "zorder": 1.6}
        elif look is not None:
            style = {"color": LIGHT[look.colour], "linewidth": 1.2, "zorder": 2.0}
            if look.dashes:
                style["linestyle"] = (0, tuple(_POINTS * d for d in look.dashes))
        axis.plot(curve.x, curve.y, label=curve.label, **(style | _MARKS.get(curve.style, {})))
    axis.set(title=chart.title, xlabel=chart.x_label, ylabel=chart.y_label)
    if chart.logarithmic:
        axis.set(xscale="log", yscale="log")
    axis.set_ylim(chart.y_range or _limits(chart))
    if chart.x_range is None:
        axis.margins(x=0.05 if any(c.style in MARKS for c in chart.curves) else 0.0)
    else:
        axis.set_xlim(chart.x_range)
    axis.grid(alpha=0.3)


def _draw_region(axis: Any, region: Region) -> None:
    """Fill rings, holes left out, or draw lines with their label in the middle of each."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    ends = np.flatnonzero(np.isnan(region.x))
    pieces = [
        np.column_stack([x, y])
        for x, y in zip(np.split(region.x, ends), np.split(region.y, ends), strict=True)
    ]
    pieces = [piece[np.isfinite(piece[:, 0])] for piece in pieces]
    if region.fill:
        rings = [np.vstack([piece, piece[:1]]) for piece in pieces if len(piece) > 2]
        outline = Outline.make_compound_path(*(Outline(ring, closed=True) for ring in rings))
        axis.add_patch(PathPatch(outline, facecolor=region.fill, edgecolor="none", zorder=0.5))
        return
    style: dict[str, Any] = {"color": LIGHT[4], "linewidth": 1.8} if region.is_bold else _CONTOUR
    for piece in pieces:
        axis.plot(piece[:, 0], piece[:, 1], zorder=1.0, **style)
        if len(piece) >= FEWEST_POINTS_OF_LABEL and region.label:
            x, y = piece[len(piece) // 2]
            axis.text(x, y, region.label, fontsize="x-small", color=LIGHT_SOFT, clip_on=True)


def legend(figure: Any, axis: Any, place: str = "outside lower center") -> None:
    """
    Put the labels of an axis below it, where they cover no curve.

    Outside of what a layout of Matplotlib's places. Without one, where `place` says: the axis has to leave
    room there.
    """
    handles, labels = axis.get_legend_handles_labels()
    if labels:
        figure.legend(handles, labels, loc=place, ncols=_LABELS_A_LINE, frameon=False, fontsize="small")


def _limits(chart: Chart) -> tuple[float, float] | None:
    """None: matplotlib's own; a flat curve gets room, so that rounding is not drawn as a motion."""
    values = np.concatenate([c.y[np.isfinite(c.y)] for c in chart.curves] or [np.zeros(0)])
    if len(values) == 0 or chart.logarithmic:
        return None
    low, high = float(np.min(values)), float(np.max(values))
    if high - low > 1e-12 * max(abs(low), abs(high)):
        return None
    room = 0.1 * abs(high) or 1.0
    return low - room, high + room
