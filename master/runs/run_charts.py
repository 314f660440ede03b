"""What the page of a run draws: compared motions, plots that the file asks for, or outputs by their units."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from master.evaluation.plots import TIME, charts
from master.experiment.experiment import Experiment
from master.pages.chart import DOTTED, REFERENCE, Chart, Curve, Floats, decimated
from master.recording.recorder import Result
from master.stepping.outcome import DIVERGED, Outcome

MOST_CURVES = 6  # in a chart
MOST_CHARTS = 12
MOST_POINTS = 300_000  # of all curves, some 1.6 MB in the page

_EARLY = 0.75  # of a diverging run: what comes after it would hide it
_MUCH_LARGER = 4.0


def run_charts(experiment: Experiment, outcome: Outcome) -> tuple[list[Chart], int]:
    """Return the charts of a run, and how many outputs are not drawn for want of room."""
    result = outcome.result
    left_out = 0
    if experiment.compare is not None:
        found = charts(result, experiment.compare)
    else:
        groups = [list(group) for group in experiment.plots] or _by_unit(result)
        left_out = sum(map(len, groups[MOST_CHARTS:]))
        found = [_chart(result, group) for group in groups[:MOST_CHARTS]]
    n_points = sum(len(curve.x) for chart in found for curve in chart.curves)
    marked = [_marked(_scaled(chart, outcome), experiment, outcome) for chart in found]
    if n_points > MOST_POINTS:
        marked = [replace(chart, curves=[decimated(curve) for curve in chart.curves]) for chart in marked]
    return marked, left_out


def _by_unit(result: Result) -> list[list[str]]:
    """Group outputs by unit, a few curves a chart."""
    units: dict[str, list[str]] = {}
    for name, unit in zip(result.names, result.units, strict=True):
        units.setdefault(unit, []).append(name)
    return [names[i : i + MOST_CURVES] for names in units.values() for i in range(0, len(names), MOST_CURVES)]


def _chart(result: Result, names: Iterable[str]) -> Chart:
    curves = [Curve(name, result.time, result[name]) for name in names]
    units = list(dict.fromkeys(result.unit(curve.label) for curve in curves))
    label = "value" if units == ["1"] else f"[{', '.join(units)}]"
    return Chart("", TIME, label, curves)


def _scaled(chart: Chart, outcome: Outcome) -> Chart:
    """Scale the chart of a diverging run to what comes before its end."""
    if outcome.status != DIVERGED:
        return chart
    early = [curve.y[: max(2, int(_EARLY * len(curve.y)))] for curve in chart.curves]
    low, high = _range(early)
    lowest, highest = _range([curve.y for curve in chart.curves])
    if not high > low or highest - lowest <= _MUCH_LARGER * (high - low):
        return chart
    room = 0.5 * (high - low)
    title = "the last quarter of the run leaves this range"
    return replace(chart, title=title, y_range=(low - room, high + room))


def _range(values: Iterable[Floats]) -> tuple[float, float]:
    finite = np.concatenate([v[np.isfinite(v)] for v in values])
    return (float(np.min(finite)), float(np.max(finite))) if len(finite) else (0.0, 0.0)


def _marked(chart: Chart, experiment: Experiment, outcome: Outcome) -> Chart:
    """Add the times of events, and the limits that the curves come near to."""
    low, high = chart.y_range or _range([curve.y for curve in chart.curves])
    time = outcome.result.time
    marks: list[Curve] = []
    for curve in chart.curves:
        limit = experiment.limits.get(curve.label)
        if limit is None or curve.style == REFERENCE or chart.y_label.endswith("[mm]"):
            continue
        for bound in (limit, -limit):
            if low <= bound <= high:
                ends = np.array([time[0], time[-1]])
                marks.append(
                    Curve(f"limit {bound:g} of {curve.label}", ends, np.full(2, bound), DOTTED, curve.label)
                )
    for event in experiment.config.events:
        if event.at is not None and time[0] <= event.at <= time[-1] and high > low:
            span = max(float(time[-1] - time[0]), 1e-9)
            at = np.array([event.at, event.at + 1e-6 * span])  # upright but for a hair: times increase
            marks.append(Curve(f"event at {event.at:g} s", at, np.array([low, high]), REFERENCE))
    return replace(chart, curves=[*chart.curves, *marks])
