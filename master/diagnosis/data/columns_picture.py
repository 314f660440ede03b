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
from .draft import DraftClock, Facts

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
    x_label = "row" if _clock(recordings[0], i) is None else "time since the first row [s]"
    return Chart(column.name, x_label, f"[{told}]", [*curves, *_gaps(recordings, curves, i)])


def _clock(facts: Facts, i: int) -> DraftClock | None:
    return facts.clocks[facts.columns[i].logger]


def _curve(facts: Facts, i: int, label: str) -> Curve:
    values = facts.table.columns[facts.columns[i].name]
    clock = _clock(facts, i)
    if clock is None:
        return Curve(label, np.arange(len(values), dtype=float), values)
    t = facts.table.columns[clock.column]
    return Curve(label, unit(clock.unit).factor * (t - t[0]), values)


def _gaps(recordings: Sequence[Facts], curves: Sequence[Curve], i: int) -> list[Curve]:
    """Return upright lines at the gaps of the clocks, as one curve."""
    x: list[float] = []
    for own, curve in zip(recordings, curves, strict=True):
        clock = _clock(own, i)
        if clock is not None and clock.n_gaps:
            steps = np.diff(curve.x)
            x += curve.x[:-1][steps > GAP * np.median(steps)].tolist()
    if not x:
        return []
    low = min(float(np.min(c.y)) for c in curves)
    high = max(float(np.max(c.y)) for c in curves)
    at = np.repeat(sorted(x), 3)
    y = np.tile([low, high, np.nan], len(x))
    return [Curve(f"gaps of the clock: {len(x)}", at, y, EVENT)]
