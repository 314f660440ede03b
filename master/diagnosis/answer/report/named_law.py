"""A named law over the signals that decide it: the law, its band, and what was measured in its slot."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from master.diagnosis.judge.part_result import PartResult
from master.pages.chart import CIRCLE, EVENT, Chart, Curve, Region
from master.pages.palette import LIGHT, LIGHT_REFERENCE, LIGHT_SOFT

from .drawing import new_grid, role_label
from .law_in_slot import LawInSlot, LawOver

HEIGHT = 4.4
GAPS = (1.0, 0.0)  # inch
MOST_POINTS = 3000
LOOP_POINTS = 4000
LAW, MEASURED, ROWS, BAND = "law", "measured, mean of a bin", "measured, single rows", "law ± 2 deviations"
BARS = "its two deviations"
OPACITY = 0.2


def law_figure(part: PartResult, law: LawInSlot) -> Figure:
    """Draw a law over each signal that decides it."""
    figure, axes = new_grid(1, len(law.over), HEIGHT, GAPS, sharey=True)
    for ax, over in zip(axes[0], law.over, strict=True):
        _draw(ax, law, over)
        ax.set_xlabel(role_label(part.study.system, law.placed.place, over.role))
        ax.xaxis.set_major_locator(MaxNLocator(5))
        ax.grid(alpha=0.3)
        low, high = _range(law, over)
        ax.set_ylim(low, high)
    axes[0, 0].set_ylabel(_added_label(part, law))
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="upper center", ncols=4, frameon=False)
    return figure


def law_charts(part: PartResult, law: LawInSlot) -> list[Chart]:
    """Return the same to zoom into, of a law over one signal; none of a loop."""
    charts = []
    for over in law.over:
        curve = over.curve
        if curve is None:
            return []
        curves = [Curve(LAW, curve.x, curve.y)]
        found = over.measured
        if found is not None:
            half = 2.0 * found.deviation
            bars = np.column_stack([found.y - half, found.y + half, np.full(len(half), np.nan)])
            curves.append(Curve(BARS, np.repeat(found.x, 3), bars.ravel(), EVENT))
            curves.append(Curve(MEASURED, found.x, found.y, CIRCLE))
        ring_x = np.concatenate([curve.x, curve.x[::-1]])
        ring_y = np.concatenate([curve.low, curve.high[::-1]])
        charts.append(
            Chart(
                str(law.placed),
                role_label(part.study.system, law.placed.place, over.role),
                _added_label(part, law),
                curves,
                y_range=_range(law, over),
                regions=[Region(ring_x, ring_y, fill=f"{LIGHT[0]}{round(255 * OPACITY):02x}", label=BAND)],
            )
        )
    return charts


def law_text(law: LawInSlot) -> str:
    """Say what is drawn, and why something is not."""
    if law.why_not:
        return f"No picture of this law: {law.why_not}."
    is_loop = any(over.curve is None for over in law.over)
    told = [
        "What the law adds in its slot along the recording."
        if is_loop
        else "The law, with two standard deviations by the covariance of its parameters."
    ]
    measured = [over.measured for over in law.over if over.measured is not None]
    if law.why_no_points:
        told.append(f"Nothing measured is drawn with it: {law.why_no_points}.")
    elif is_loop:
        told.append("Grey: what was measured there on the open rows: the law and what it leaves.")
    else:
        told.append(
            "Circles: what was measured there on the open rows, as means over bins with two deviations: the "
            "law and what it leaves, brought back to the slot through the linear response of the outputs."
        )
    missing = sum(m.n_unresolved for m in measured)
    if missing:
        told.append(
            f"Left out: {missing} bin{'s' if missing > 1 else ''} that the recording does not resolve."
        )
    return " ".join(told)


def _draw(ax: Any, law: LawInSlot, over: LawOver) -> None:
    found = over.measured
    if found is not None and len(found.cloud_x):
        every = max(1, len(found.cloud_x) // MOST_POINTS)
        x = found.cloud_x[::every]
        y = found.cloud_y[::every]
        ax.plot(x, y, ".", color=LIGHT_REFERENCE, markersize=2.5, label=ROWS)
    if over.curve is None:
        for x, y in _loops(law, over):
            ax.plot(x, y, color=LIGHT[0], linewidth=0.9)
        ax.plot([], [], color=LIGHT[0], label=LAW)
        return
    curve = over.curve
    ax.fill_between(curve.x, curve.low, curve.high, color=LIGHT[0], alpha=OPACITY, linewidth=0.0, label=BAND)
    ax.plot(curve.x, curve.y, color=LIGHT[0], linewidth=1.6, label=LAW)
    if found is not None:
        ax.errorbar(
            found.x,
            found.y,
            2.0 * found.deviation,
            fmt="o",
            color=LIGHT[1],
            ecolor=LIGHT_SOFT,
            markersize=4.5,
            linewidth=1.0,
            label=MEASURED,
        )


def _loops(law: LawInSlot, over: LawOver) -> list[tuple[Any, Any]]:
    """Path of each recording, thinned as a whole."""
    every = max(1, len(law.added) // LOOP_POINTS)
    ends = [*law.recordings[1:], len(law.added)]
    return [
        (over.x[begin:end:every], law.added[begin:end:every])
        for begin, end in zip(law.recordings, ends, strict=True)
    ]


def _range(law: LawInSlot, over: LawOver) -> tuple[float, float]:
    """Range of the law and of the bins; single rows are noise and may lie outside."""
    shown = [law.added]
    if over.curve is not None:
        shown.append(over.curve.y)
    found = over.measured
    if found is not None:
        shown += [found.y - 2.0 * found.deviation, found.y + 2.0 * found.deviation]
        if len(found.cloud_y):
            shown.append(np.quantile(found.cloud_y, (0.005, 0.995)))
    values = np.concatenate(shown)
    low, high = float(values.min()), float(values.max())
    room = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
    return low - room, high + room


def _added_label(part: PartResult, law: LawInSlot) -> str:
    placed = law.placed
    return f"added to {placed.slot} [{part.study.system.slots(placed.fmu)[placed.slot].unit}]"
