"""The rounds of the search: gain of each effect that was fitted, with its uncertainty."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from master.diagnosis.numerics.gains import ERRORS, SMALLEST_GAIN
from master.diagnosis.search.rounds import Round, SearchResult

from .drawing import AFTER, COLOURS, new_figure

ROW = 0.26


def rivals(found: SearchResult) -> Figure:
    """Draw one axis a round, best effect on top."""
    rounds = [step for step in found.rounds if step.ranked]
    counts = [len(step.ranked) for step in rounds]
    figure = new_figure(ROW * sum(counts) + 0.8 * len(rounds) + 0.4)
    axes: Any = figure.subplots(len(rounds), 1, squeeze=False, height_ratios=[n + 1 for n in counts])
    for i, (ax, step) in enumerate(zip(axes[:, 0], rounds, strict=True), start=1):
        _round(ax, step)
        ax.set_title(f"round {i}", loc="left", fontsize="medium")
    axes[-1, 0].set_xlabel("gain on held-out blocks [1]")
    return figure


def _round(ax: Any, step: Round) -> None:
    ranked = step.ranked[::-1]
    winner = step.family[0] if step.family else None
    ax.barh(
        [r.name for r in ranked],
        [r.gain.mean for r in ranked],
        xerr=[ERRORS * r.gain.error for r in ranked],
        color=[COLOURS[AFTER] if r is winner else "0.7" for r in ranked],
        error_kw={"ecolor": "0.3", "elinewidth": 1.0},
    )
    ax.axvline(SMALLEST_GAIN, color="0.4", linewidth=0.8)
    ax.grid(axis="x", alpha=0.3)
    ax.margins(y=0.03)
