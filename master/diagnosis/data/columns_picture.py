"""All columns of a recording as a picture: what they show before anything is assumed of them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from master.errors import DataError
from master.fmi.unit_names import unit
from master.pages.chart import EVENT, Chart, Curve
from master.pages.picture import save
from master.recording.folder import reason

from .clock import GAP
from .draft import Facts

MOST_COLUMNS = 24


def draw_columns(recordings: Sequence[Facts], path: Path) -> Path:
    """
    Draw the columns of recordings that have the same ones, a chart each, as PNG.

    Raises:
        DataError: If it cannot be written.
    """
    names = [c.name for c in recordings[0].columns]
    charts = [_chart(recordings, i) for i in range(min(len(names), MOST_COLUMNS))]
    title = ", ".join(own.table.path.name for own in recordings)
    if len(names) > MOST_COLUMNS:
        title += f"\n{len(names) - MOST_COLUMNS} more columns are not drawn"
    try:
        return save(title, charts, path)
    except OSError as error:
        raise DataError(f"{path}: cannot be written: {reason(error)}") from None


def _chart(recordings: Sequence[Facts], i: int) -> Chart:
    column = recordings[0].columns[i]
    label = "" if len(recordings) > 1 else column.name
    curves = [_curve(own, i, label or own.table.path.name) for own in recordings]
    told = column.unit or "unit not told"
    return Chart(column.name, _x_label(recordings[0]), f"[{told}]", [*curves, *_gaps(recordings, curves)])


def _x_label(facts: Facts) -> str:
    return "row" if facts.clock is None else "time since the first row [s]"


def _curve(facts: Facts, i: int, label: str) -> Curve:
    values = facts.table.columns[facts.columns[i].name]
    if facts.clock is None:
        return Curve(label, np.arange(len(values), dtype=float), values)
    t = facts.table.columns[facts.clock.column]
    return Curve(label, unit(facts.clock.unit).factor * (t - t[0]), values)


def _gaps(recordings: Sequence[Facts], curves: Sequence[Curve]) -> list[Curve]:
    """Return upright lines at the gaps of the clocks, as one curve."""
    x: list[float] = []
    for own, curve in zip(recordings, curves, strict=True):
        if own.clock is not None and own.clock.n_gaps:
            steps = np.diff(curve.x)
            x += curve.x[:-1][steps > GAP * np.median(steps)].tolist()
    if not x:
        return []
    low = min(float(np.min(c.y)) for c in curves)
    high = max(float(np.max(c.y)) for c in curves)
    at = np.repeat(sorted(x), 3)
    y = np.tile([low, high, np.nan], len(x))
    return [Curve(f"gaps of the clock: {len(x)}", at, y, EVENT)]
