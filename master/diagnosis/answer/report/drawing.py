"""What the panels share: colours, lines that keep their peaks and break at gaps, units of axes."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from fmu_sources.effects.framework.roles import roles
from master.diagnosis.case.cut import CutSystem
from master.diagnosis.numerics.arrays import Array
from master.pages.palette import DASHES, LIGHT, LIGHT_REFERENCE
from master.pages.plain_text import as_written
from master.text.signal_name import SignalName

MOST_BINS = 1155  # as many as there are pixels across
MEASURED, BEFORE, AFTER = "measured", "before", "after"
COLOURS = {MEASURED: LIGHT_REFERENCE, AFTER: LIGHT[0], BEFORE: LIGHT[1]}
LINES: Mapping[str, Any] = {MEASURED: "-", AFTER: "-", BEFORE: (0, DASHES[1])}
STYLES: Mapping[str, Mapping[str, float]] = {
    MEASURED: {"linewidth": 3.0},
    BEFORE: {"linewidth": 0.9},
    AFTER: {"linewidth": 0.9},
}
GAP = 1.5
WIDTH = 10.5
LEFT, RIGHT, BELOW, ABOVE = 1.1, 0.2, 0.55, 0.65  # inch around the axes of a grid


def new_figure(height: float) -> Figure:
    """Make a figure of the width of the page [inch]."""
    figure = Figure((WIDTH, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def plain_figure(height: float) -> Figure:
    """Make a figure of the width of the page [inch], in which nothing is placed yet."""
    figure = Figure((WIDTH, height))
    FigureCanvasAgg(figure)
    return figure


def place(figure: Any, height: float, *, left: float, below: float, above: float) -> None:
    """
    Leave room [inch] around the axes of a figure, or a part of one, of a height.

    Matplotlib's own layout measures each number at the axes twice before it draws, which takes longer
    than to draw.
    """
    figure.subplots_adjust(
        left=left / WIDTH, right=1.0 - RIGHT / WIDTH, bottom=below / height, top=1.0 - above / height
    )


def new_grid(
    rows: int, columns: int, height: float, gaps: tuple[float, float], **options: Any
) -> tuple[Figure, Any]:
    """
    Make a figure with axes in rows and columns, placed in inches, shape (rows, columns).

    Args:
        rows: Number of rows.
        columns: Number of columns.
        height: Of the figure [inch].
        gaps: Between columns, and between rows [inch].
        options: Of Matplotlib's `subplots`.
    """
    figure = plain_figure(height)
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    across, down = gaps
    own_width = (WIDTH - LEFT - RIGHT - across * (columns - 1)) / columns
    own_height = (height - BELOW - ABOVE - down * (rows - 1)) / rows
    place(figure, height, left=LEFT, below=BELOW, above=ABOVE)
    figure.subplots_adjust(wspace=across / own_width, hspace=down / own_height)
    return figure, axes


def save(figure: Figure, path: Path) -> Path:
    """Write a PNG."""
    as_written(figure).savefig(path, dpi=110)
    return path


def draw(ax: Any, t: Array, series: Mapping[str, Array]) -> None:
    """Draw curves over time by what they are: measured, before, after; shape (n,) each."""
    for name, values in series.items():
        x, y = thinned(*broken(t, values))
        ax.plot(x, y, color=COLOURS[name], linestyle=LINES[name], label=name, **STYLES[name])
    ax.grid(alpha=0.3)
    ax.margins(x=0.0)


def legend(figure: Figure, ax: Any) -> None:
    """Put the labels of an axis above the whole figure, where a grid leaves room for them."""
    figure.legend(*ax.get_legend_handles_labels(), loc="upper center", ncols=4, frameon=False)


def broken(t: Array, values: Array) -> tuple[Array, Array]:
    """Put a row of NaN where rows are missing or another recording begins, so that no line bridges them."""
    steps = np.diff(t)
    gaps = np.flatnonzero((steps > GAP * float(np.median(steps))) | (steps <= 0.0)) + 1
    return np.insert(t, gaps, np.nan), np.insert(values, gaps, np.nan)


def thinned(t: Array, values: Array) -> tuple[Array, Array]:
    """Keep the smallest and the largest value of each of many bins, in time order, and all gaps."""
    if len(t) <= 2 * MOST_BINS:
        return t, values
    edges = np.linspace(0, len(t), MOST_BINS + 1).astype(int)
    kept = set(np.flatnonzero(np.isnan(t)).tolist())
    for a, b in itertools.pairwise(edges.tolist()):
        own = values[a:b]
        if np.isfinite(own).any():
            kept |= {a + int(np.nanargmin(own)), a + int(np.nanargmax(own))}
    rows = np.array(sorted(kept))
    return t[rows], values[rows]


def label(system: CutSystem, key: str) -> str:
    """Name a variable `fmu.name` with its unit, for an axis."""
    fmu, name = SignalName(key).parts
    return f"{name} [{unit_of(system, key)}]" if fmu in system.descriptions else key


def unit_of(system: CutSystem, key: str) -> str:
    """Unit of a variable `fmu.name`."""
    fmu, name = SignalName(key).parts
    return system.descriptions[fmu].by_name[name].unit_name


def role_label(system: CutSystem, key: str, role: str) -> str:
    """Name a role of a slot `fmu.slot` with its unit."""
    fmu, name = SignalName(key).parts
    slot = system.slots(fmu)[name]
    found = {r: slot.signals[signal] for r, signal in roles(slot).items()}
    units = {"value": slot.unit, "time": "s", **found}
    return f"{role} [{units[role]}]"
