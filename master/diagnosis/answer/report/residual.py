"""What is left on the open rows: over time, its spectrum, its correlations and its restoring-force map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from scipy.signal import welch

from master.diagnosis.judge.evidence import worst_output
from master.diagnosis.judge.part_result import PartResult
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.whiteness import Correlation

from .drawing import (
    AFTER,
    BEFORE,
    BELOW,
    COLOURS,
    LEFT,
    LINES,
    draw,
    legend,
    new_grid,
    place,
    plain_figure,
    role_label,
    unit_of,
)

MOST_POINTS = 4000
MOST_BARS = 8
SEGMENT = 2048
SEGMENTS = 5
HEIGHT = 6.2
GAPS = (0.0, 0.6)  # inch
HEIGHT_OF_BARS = 2.6
HEIGHT_OF_MAP = 3.4
LETTER, SPACE, ROOM_OF_TITLE = 0.085, 0.2, 0.35  # inch
MOST_OF_NAMES = 6.0  # inch
LIMIT = 98.0


@dataclass(frozen=True)
class Residuals:
    """Residuals of one output, before and after, shape (rows,); NaN where a row is not open."""

    signal: str
    unit: str
    left: Mapping[str, Array]


def residuals_of(part: PartResult) -> Residuals:
    """Return those of the output that the model before explains worst."""
    study = part.study
    worst = worst_output(study)
    left = {BEFORE: (study.measured - part.base.predicted)[:, worst]}
    if part.has_effect:
        left = {AFTER: (study.measured - part.fit.predicted)[:, worst]} | left
    key = part.outputs[worst]
    return Residuals(f"{key.partition('.')[2]}: residual", unit_of(study.system, key), left)


def residual(part: PartResult) -> Figure:
    """Draw the residual over time, and its spectrum."""
    found = residuals_of(part)
    figure, axes = new_grid(2, 1, HEIGHT, GAPS)
    over_time = axes[0, 0]
    spectrum = axes[1, 0]
    _time(over_time, part, found.left, f"{found.signal} [{found.unit}]")
    legend(figure, over_time)
    _spectrum(spectrum, part, found.left, found.unit)
    figure.align_ylabels(axes)
    return figure


def where(part: PartResult) -> Figure:
    """Draw what the residual correlates with, and its map over the state."""
    found = residuals_of(part)
    slot = _slot(part)
    heights = [HEIGHT_OF_BARS, HEIGHT_OF_MAP] if slot else [HEIGHT_OF_BARS]
    figure = plain_figure(sum(heights))
    rows: Any = figure.subfigures(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0]
    letters = max([0, *(len(_name(c)) for c in part.correlations[:MOST_BARS])])
    left = SPACE + min(LETTER * letters, MOST_OF_NAMES)
    place(rows[0], HEIGHT_OF_BARS, left=left, below=BELOW, above=SPACE)
    _correlations(rows[0].subplots(), part)
    if slot:
        place(rows[1], HEIGHT_OF_MAP, left=LEFT, below=BELOW, above=ROOM_OF_TITLE)
        _maps(rows[1], part, found.left, slot, found.unit)
    return figure


def _time(ax: Any, part: PartResult, left: Mapping[str, Array], name: str) -> None:
    rows = part.in_use
    t = np.asarray(np.flatnonzero(rows) * part.row_period, dtype=float)
    draw(ax, t, {k: v[rows] for k, v in left.items()})
    ax.set(xlabel="time [s]", ylabel=name)


def spectrum_of(part: PartResult, values: Array) -> tuple[Array, Array]:
    """Frequencies [Hz] above 0 and amplitude density of a residual of shape (rows,)."""
    own = np.nan_to_num(values[part.in_use])
    segment = min(SEGMENT, max(8, len(own) // SEGMENTS))
    frequencies, power = welch(own, 1.0 / part.row_period, nperseg=segment)
    return frequencies[1:], np.sqrt(power[1:])


def _spectrum(ax: Any, part: PartResult, left: Mapping[str, Array], unit: str) -> None:
    for name, values in left.items():
        frequencies, density = spectrum_of(part, values)
        ax.loglog(frequencies, density, color=COLOURS[name], linestyle=LINES[name], linewidth=0.9)
    ax.grid(alpha=0.3)
    ax.set(xlabel="frequency [Hz]", ylabel=f"amplitude density [{unit}/sqrt(Hz)]")


def _correlations(ax: Any, part: PartResult) -> None:
    found = part.correlations[:MOST_BARS][::-1]
    ax.barh(
        [_name(c) for c in found],
        [abs(c.value) for c in found],
        color=[COLOURS[AFTER] if c.is_found else "0.7" for c in found],
    )
    ax.set_xlabel("abs(cross-correlation) [1], before")
    ax.margins(y=0.02)
    if not found:
        ax.text(0.5, 0.5, "no signal to correlate with", ha="center", transform=ax.transAxes)
        ax.set_yticks([])


def _name(found: Correlation) -> str:
    """What a residual correlates with, without the FMU that it is in."""
    return found.basis.partition(".")[2] or found.basis


def _slot(part: PartResult) -> str | None:
    """Slot of the effect, else the first, that has a signal to draw the map over."""
    signals = part.study.signals
    places = [e.place for e in part.chosen.effects]
    return next((s for s in (*places, *signals) if s in signals and len(_axes(signals[s])) == 2), None)


def _axes(signals: dict[str, Array]) -> list[str]:
    return [str(r) for r in ("position", "velocity", "value") if r in signals][:2]


def _maps(figure: Any, part: PartResult, left: Mapping[str, Array], slot: str, unit: str) -> None:
    study = part.study
    first, second = _axes(study.signals[slot])
    x, y = (study.bench.compared_rows(study.signals[slot][r]) for r in (first, second))
    rows = part.in_use
    every = max(1, int(rows.sum()) // MOST_POINTS)
    limit = float(np.nanpercentile(np.abs(left[BEFORE][rows]), LIMIT)) or 1.0
    axes: Any = figure.subplots(1, 2, sharex=True, sharey=True)
    for ax, name in zip(axes, (BEFORE, AFTER), strict=True):
        if name not in left:
            ax.set_axis_off()
            continue
        colours = left[name][rows][::every]
        points = ax.scatter(
            x[rows][::every], y[rows][::every], c=colours, s=4, cmap="RdBu_r", vmin=-limit, vmax=limit
        )
        ax.set_title(f"{slot}, {name}", loc="left", fontsize="medium")
        ax.set_xlabel(role_label(study.system, slot, first))
        ax.xaxis.set_major_locator(MaxNLocator(5))
        if name == BEFORE:
            ax.set_ylabel(role_label(study.system, slot, second))
    figure.colorbar(points, ax=axes, label=f"residual [{unit}]", extend="both")
