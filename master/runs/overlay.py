"""Runs drawn over each other: a page or a picture, the signals that differ most first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from master.errors import DataError
from master.pages.chart import REFERENCE, Chart, Curve, decimated
from master.pages.picture import save
from master.pages.render import number, render
from master.recording.folder import reason
from master.recording.whole_file import write_whole

from .differences import Comparison, SignalDifference, common_rows

MOST_SIGNALS = 12
_TIME = "time [s]"


def draw(comparisons: Sequence[Comparison], path: Path) -> Path:
    """
    Draw runs over their reference.

    Args:
        comparisons: All against one reference.
        path: `.html` for a page, `.png` for a picture.

    Raises:
        DataError: If it cannot be written.
    """
    names = drawn_signals(comparisons)
    charts = [chart for name in names for chart in _charts(comparisons, name)]
    title = f"Compared with {comparisons[0].reference.label}"
    try:
        if path.suffix.lower() == ".png":
            path.parent.mkdir(parents=True, exist_ok=True)
            return save(title, charts, path)
        write_whole(path, _page(title, comparisons, names, charts))
    except OSError as error:
        raise DataError(f"{path}: cannot be written: {reason(error)}") from None
    return path


def drawn_signals(comparisons: Sequence[Comparison]) -> list[str]:
    """Names of the signals that are drawn: those beyond the tolerance first, then as recorded."""
    rank: dict[str, int] = {}
    for comparison in comparisons:
        for d in comparison.differences:
            own = 0 if not d.is_within else 1 if d.unequal else 2
            rank[d.name] = min(own, rank.get(d.name, own))
    return sorted(rank, key=lambda name: rank[name])[:MOST_SIGNALS]


def _charts(comparisons: Sequence[Comparison], name: str) -> list[Chart]:
    """One chart with the signal of all runs, and one with the differences where there are any."""
    reference = comparisons[0].reference
    unit = reference.units.get(name, "1")
    curves = [Curve(reference.label, reference.time, reference.signals[name], REFERENCE)]
    apart = []
    for i, (comparison, d) in enumerate(_with(comparisons, name), start=1):
        other = comparison.other
        label = other.label if len(comparisons) == 1 else f"{i}. {other.label}"
        curves.append(Curve(label, other.time, other.signals[d.other_name]))
        if d.unequal:
            mine, theirs = common_rows(reference.time, other.time)
            difference = other.signals[d.other_name][theirs] - reference.signals[name][mine]
            apart.append(Curve(f"{label} - reference", reference.time[mine], difference))
    charts = [Chart(name, _TIME, f"{name} [{unit}]", curves)]
    if apart:
        charts.append(Chart(f"difference of {name}", _TIME, f"difference [{unit}]", apart))
    return charts


def _with(comparisons: Sequence[Comparison], name: str) -> list[tuple[Comparison, SignalDifference]]:
    return [(c, d) for c in comparisons for d in c.differences if d.name == name]


def _page(
    title: str, comparisons: Sequence[Comparison], names: Sequence[str], charts: Sequence[Chart]
) -> str:
    thinned = [replace(chart, curves=[decimated(curve) for curve in chart.curves]) for chart in charts]
    n_signals = len({d.name for c in comparisons for d in c.differences})
    return render(
        "master.runs",
        "comparison.html.j2",
        heading=title,
        charts={"overlay": thinned},
        comparisons=comparisons,
        rows=[[_row(d) for d in c.differences] for c in comparisons],
        n_drawn=len(names),
        n_signals=n_signals,
    )


def _row(d: SignalDifference) -> list[str]:
    values = (d.max_abs, d.max_at, d.rms, d.first_beyond)
    name = f"{d.name} [{d.unit}]" if d.unit else d.name
    return [name, *map(number, values), str(d.beyond), "yes" if d.is_within else "no"]
