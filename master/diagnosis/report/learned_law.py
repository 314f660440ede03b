"""The learned law as a map over its two signals, and cuts through it."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fmu_sources.effects.learned import splines

from ..learning import coefficients
from ..part_result import PartResult
from ..tables import Array
from .drawing import new_figure, role_label

N_GRID = 101
CUTS = (-0.5, 0.0, 0.5)
COLOURS = ("#1f6fb2", "0.15", "#c8553d")
_ARRAYS: Any = SimpleNamespace(where=np.where, fabs=np.fabs)


def law(part: PartResult) -> Figure:
    """Draw the force or signal that the last effect adds."""
    added, system = part.chosen.added[-1], part.study.system
    slot = f"{added.fmu}.{added.slot}"
    names = added.effect.removeprefix("learned_").split("_")
    ranges = [_half_range(part, which) for which in "ab"]
    share = np.linspace(-1.0, 1.0, N_GRID)
    values = surface(coefficients(added, part.fit), share)
    unit = system.slots(added.fmu)[added.slot].unit
    figure = new_figure(4.2)
    axes: Any = figure.subplots(1, 2)
    labels = [role_label(system, slot, name) for name in names]
    _map(axes[0], share * ranges[0], share * ranges[1], values)
    axes[0].set(xlabel=labels[0], ylabel=labels[1])
    figure.colorbar(axes[0].collections[0], ax=axes[0], label=f"added to {added.slot} [{unit}]")
    for cut, colour in zip(CUTS, COLOURS, strict=True):
        column = values[:, round((cut + 1.0) / 2.0 * (N_GRID - 1))]
        axes[1].plot(share * ranges[0], column, color=colour, label=f"{names[1]} = {cut * ranges[1]:.3g}")
    axes[1].set(xlabel=labels[0], ylabel=f"added to {added.slot} [{unit}]")
    axes[1].grid(alpha=0.3)
    axes[1].legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False, fontsize="small")
    return figure


def surface(c: Array, share: Array) -> Array:
    """Values of a law with coefficients (7, 7) on a grid of shares of the half ranges, shape (n, n)."""
    basis = np.stack(splines(share, _ARRAYS))
    return np.asarray(basis.T @ c @ basis)


def _map(ax: Any, x: Array, y: Array, values: Array) -> None:
    limit = float(np.abs(values).max()) or 1.0
    ax.pcolormesh(x, y, values.T, cmap="RdBu_r", vmin=-limit, vmax=limit, shading="auto", rasterized=True)


def _half_range(part: PartResult, which: str) -> float:
    added = part.chosen.added[-1]
    found = part.chosen.fixed.get(f"{added.fmu}.{added.prefix}_half_range_{which}", math.nan)
    return float(found)
