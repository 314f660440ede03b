"""What is left on the open rows: over time, its spectrum, its correlations and its restoring-force map."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from scipy.signal import welch

from master.diagnosis.judge.evidence import worst_output
from master.diagnosis.judge.part_result import PartResult
from master.diagnosis.numerics.arrays import Array

from .drawing import AFTER, BEFORE, COLOURS, draw, legend, new_figure, role_label, unit_of

MOST_POINTS, MOST_BARS = 4000, 8
SEGMENT, SEGMENTS = 2048, 5
HEIGHT, HEIGHT_OF_MAP = 6.2, 3.4
LIMIT = 98.0


def residual(part: PartResult) -> Figure:
    """Draw the output that the model before explains worst."""
    study = part.study
    worst = worst_output(study)
    left = {
        name: (study.measured - fit.predicted)[:, worst]
        for name, fit in ((BEFORE, part.base), (AFTER, part.fit))
        if name == BEFORE or part.has_effect
    }
    slot = _slot(part)
    figure = new_figure(HEIGHT + (HEIGHT_OF_MAP if slot else 0.0))
    rows: Any = figure.subfigures(3 if slot else 2, 1)
    key = part.outputs[worst]
    unit = unit_of(study.system, key)
    _time(rows[0], part, left, f"{key.partition('.')[2]}: residual [{unit}]")
    axes: Any = rows[1].subplots(1, 2, width_ratios=(1, 1))
    _spectrum(axes[0], part, left, unit)
    _correlations(axes[1], part)
    if slot:
        _maps(rows[2], part, left, slot, unit)
    return figure


def _time(figure: Any, part: PartResult, left: dict[str, Array], name: str) -> None:
    ax: Any = figure.subplots()
    rows = part.in_use
    t = np.asarray(np.flatnonzero(rows) * part.row_period, dtype=float)
    draw(ax, t, {k: v[rows] for k, v in left.items()})
    ax.set(xlabel="time [s]", ylabel=name)
    legend(figure, ax)


def _spectrum(ax: Any, part: PartResult, left: dict[str, Array], unit: str) -> None:
    rows = part.in_use
    for name, values in left.items():
        own = np.nan_to_num(values[rows])
        f, power = welch(own, 1.0 / part.row_period, nperseg=min(SEGMENT, max(8, len(own) // SEGMENTS)))
        ax.loglog(f[1:], np.sqrt(power[1:]), color=COLOURS[name], linewidth=0.9)
    ax.grid(alpha=0.3)
    ax.set(xlabel="frequency [Hz]", ylabel=f"amplitude density [{unit}/sqrt(Hz)]")


def _correlations(ax: Any, part: PartResult) -> None:
    found = part.correlations[:MOST_BARS][::-1]
    names = [c.basis.partition(".")[2] or c.basis for c in found]
    ax.barh(
        names, [abs(c.value) for c in found], color=[COLOURS[AFTER] if c.is_found else "0.7" for c in found]
    )
    ax.set_xlabel("abs(cross-correlation) [1], before")
    ax.margins(y=0.02)
    if not found:
        ax.text(0.5, 0.5, "no signal to correlate with", ha="center", transform=ax.transAxes)
        ax.set_yticks([])


def _slot(part: PartResult) -> str | None:
    """Slot of the effect, else the first, that has a signal to draw the map over."""
    signals = part.study.signals
    places = [e.place for e in part.chosen.effects]
    return next((s for s in (*places, *signals) if s in signals and len(_axes(signals[s])) == 2), None)


def _axes(signals: dict[str, Array]) -> list[str]:
    return [str(r) for r in ("position", "velocity", "value") if r in signals][:2]


def _maps(figure: Any, part: PartResult, left: dict[str, Array], slot: str, unit: str) -> None:
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
