"""What is drawn, apart from how: the page's script and the static pictures draw the same curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .palette import DOTS, SOLID, Look, look

Floats = NDArray[np.float64]

LINE, REFERENCE, DOTTED, CROSS, CIRCLE, EVENT = "line", "reference", "dotted", "cross", "circle", "event"
MARKS = (CROSS, CIRCLE)
GREY = (REFERENCE, EVENT)  # have no colour of the palette
COLUMNS = 700
FEWEST_POINTS_OF_LABEL = 5  # a shorter line of equal value has no room for its label


@dataclass(frozen=True)
class Curve:
    """
    A line or marks, shapes (n,); NaN breaks a line.

    A reference is wide, grey and under the others, an event thin and grey; a dotted curve has the colour of
    the one named `like`.
    """

    label: str
    x: Floats
    y: Floats
    style: str = LINE
    like: str = ""


@dataclass(frozen=True)
class Region:
    """
    Closed rings under the curves, filled with `fill` (#rrggbbaa); or, without it, lines of equal value.

    Shapes (n,); NaN is between rings or lines. Lines are thin, grey and dashed and have the label, or bold.
    """

    x: Floats
    y: Floats
    fill: str = ""
    label: str = ""
    is_bold: bool = False


@dataclass(frozen=True)
class Chart:
    """One pair of axes, their labels with units; `y_range` cuts off what runs away."""

    title: str
    x_label: str
    y_label: str
    curves: Sequence[Curve]
    y_range: tuple[float, float] | None = None
    x_range: tuple[float, float] | None = None
    logarithmic: bool = False
    regions: Sequence[Region] = ()

    @property
    def looks(self) -> list[Look | None]:
        """Colour and dashes of each curve; None for what is grey."""
        names = [c.label for c in self.curves if c.style not in GREY and not c.like]
        own = {name: look(place) for place, name in enumerate(names)}
        return [_look(curve, own) for curve in self.curves]


def _look(curve: Curve, own: dict[str, Look]) -> Look | None:
    if curve.style in GREY:
        return None
    colour, dashes = own[curve.like or curve.label]
    if curve.style in MARKS:
        return Look(colour, SOLID)
    return Look(colour, DOTS if curve.style == DOTTED else dashes)


def decimated(curve: Curve, columns: int = COLUMNS) -> Curve:
    """Keep the ends, and of each of many columns the smallest and the largest value; gaps stay gaps."""
    n = len(curve.x)
    if curve.style in MARKS or n <= 2 * columns:
        return curve
    edges = np.linspace(0, n, columns + 1).astype(int)
    gaps = np.flatnonzero(np.isnan(curve.y))
    begins_of_gaps = gaps[np.diff(gaps, prepend=-2) > 1]
    lowest = _first_extremes(curve.y, edges, np.fmin)
    highest = _first_extremes(curve.y, edges, np.fmax)
    rows = np.unique(np.concatenate([[0, n - 1], begins_of_gaps, lowest, highest]))
    return replace(curve, x=curve.x[rows], y=curve.y[rows])


def _first_extremes(y: Floats, edges: NDArray[np.intp], extreme: np.ufunc) -> NDArray[np.intp]:
    """Row of the first extreme value in each column that has one."""
    column = np.repeat(np.arange(len(edges) - 1), np.diff(edges))
    rows = np.flatnonzero(y == extreme.reduceat(y, edges[:-1])[column])
    _, first = np.unique(column[rows], return_index=True)
    return rows[first]
