"""What is drawn, apart from how: the page and the PNG files draw the same curves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from master.reproduce.measures.runs import Recording, Run, Wanted

Floats = NDArray[np.float64]

LINE, REFERENCE, DASHED, CROSS, CIRCLE = "line", "reference", "dashed", "cross", "circle"
COLOURS = ("#0b6fb8", "#d1495b", "#2e8b57", "#b8860b", "#7b4fa3", "#444444")
REFERENCE_COLOUR = "#9a9a9a"
COLUMNS = 700


@dataclass(frozen=True)
class Curve:
    """A line or marks; the reference is wide and grey behind the others; `like` names one of its colour."""

    label: str
    x: Floats
    y: Floats
    style: str = LINE
    like: str = ""


@dataclass(frozen=True)
class Panel:
    """One pair of axes; `y_range` cuts off what runs away."""

    title: str
    x_label: str
    y_label: str
    curves: Sequence[Curve]
    y_range: tuple[float, float] | None = None
    x_range: tuple[float, float] | None = None


@dataclass(frozen=True)
class Figure:
    """A figure of the paper: what it shows there, what ours shows, the runs it needs, and how it is drawn."""

    id: str
    title: str
    paper: str
    ours: str
    runs: Mapping[Run, Sequence[str]]
    draw: Callable[[Mapping[Run, Recording]], Sequence[Panel]]

    @property
    def wishes(self) -> dict[Run, Wanted]:
        """Signals that are drawn."""
        return {run: Wanted(signals=frozenset(signals)) for run, signals in self.runs.items()}


def colours(panel: Panel) -> list[str]:
    """Give each curve its colour, the references grey, and what is like another the colour of that."""
    free = iter(COLOURS * 4)
    own = {c.label: next(free) for c in panel.curves if c.style != REFERENCE and not c.like}
    return [REFERENCE_COLOUR if c.style == REFERENCE else own[c.like or c.label] for c in panel.curves]


def decimated(curve: Curve, columns: int = COLUMNS) -> Curve:
    """Keep the least and the largest value of each column, in their order in time."""
    if curve.style in (CROSS, CIRCLE) or len(curve.x) <= 2 * columns:
        return curve
    edges = np.linspace(0, len(curve.x), columns + 1).astype(int)
    kept = {0, len(curve.x) - 1}
    for begin, end in pairwise(edges):
        kept |= {begin + int(np.argmin(curve.y[begin:end])), begin + int(np.argmax(curve.y[begin:end]))}
    rows = np.array(sorted(kept))
    return replace(curve, x=curve.x[rows], y=curve.y[rows])


def as_data(panel: Panel) -> dict[str, Any]:
    """Panel for the page's script."""
    curves = []
    for curve, colour in zip(map(decimated, panel.curves), colours(panel), strict=True):
        finite = np.isfinite(curve.y)
        curves.append(
            {
                "label": curve.label,
                "style": curve.style,
                "colour": colour,
                "x": [float(f"{v:.6g}") for v in curve.x[finite]],
                "y": [float(f"{v:.5g}") for v in curve.y[finite]],
            }
        )
    return {
        "title": panel.title,
        "x_label": panel.x_label,
        "y_label": panel.y_label,
        "x_range": panel.x_range,
        "y_range": panel.y_range,
        "curves": curves,
    }
