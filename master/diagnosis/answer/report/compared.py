"""Measured against simulated on the sealed rows, before and after."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from master.diagnosis.answer.before_after import SealedPart
from master.diagnosis.case.cut import CutSystem
from master.diagnosis.numerics.arrays import Array

from .drawing import AFTER, BEFORE, MEASURED, draw, label, legend, new_grid, unit_of

STRETCH, FEWEST = 0.06, 200
GAPS = (1.0, 0.35)  # inch


def compared(system: CutSystem, own: SealedPart) -> Figure:
    """Draw all outputs of a part: two rows an output, the second with what is left."""
    k = len(own.part.compared)
    figure, axes = new_grid(
        2 * k, 2, 3.6 * k + 0.7, GAPS, sharex="col", width_ratios=(3, 2), height_ratios=(3, 2) * k
    )
    left_before = own.measured - own.before
    worst = worst_stretch(np.sqrt(np.mean((left_before / scale_of(left_before)) ** 2, axis=1)))
    for i, name in enumerate(own.part.compared):
        series = _series(own, i)
        left = {w: series[MEASURED] - v for w, v in series.items() if w != MEASURED}
        for column, rows in enumerate((slice(None), worst)):
            for ax, curves in ((axes[2 * i, column], series), (axes[2 * i + 1, column], left)):
                draw(ax, own.t[rows], {w: v[rows] for w, v in curves.items()})
        axes[2 * i, 0].set_ylabel(label(system, name))
        axes[2 * i + 1, 0].set_ylabel(f"residual [{unit_of(system, name)}]")
        axes[2 * i, 0].set_title(name, loc="left", fontsize="medium")
        axes[2 * i, 1].set_title("where it was worst", loc="left", fontsize="medium")
    for ax in axes[-1]:
        ax.set_xlabel("time [s]")
        ax.xaxis.set_major_locator(MaxNLocator(5))
    figure.align_ylabels(axes[:, 0])
    legend(figure, axes[0, 0])
    return figure


def worst_stretch(residual: Array) -> slice:
    """Rows of a short stretch with the largest power, shape of residual (n,)."""
    n = min(len(residual), max(FEWEST, round(STRETCH * len(residual))))
    total = np.concatenate([[0.0], np.cumsum(np.nan_to_num(residual) ** 2)])
    begin = int(np.argmax(total[n:] - total[:-n]))
    return slice(begin, begin + n)


def scale_of(residual: Array) -> Array:
    """Rms of each output, 1 where it is zero, shape (outputs,)."""
    size = np.sqrt(np.nanmean(residual**2, axis=0))
    return np.where(size > 0.0, size, 1.0)


def _series(own: SealedPart, i: int) -> dict[str, Array]:
    found = {MEASURED: own.measured[:, i]}
    if not np.array_equal(own.after, own.before):
        found[AFTER] = own.after[:, i]
    return found | {BEFORE: own.before[:, i]}
