"""What a run draws: compared motions and plots that the file asks for, else outputs that change."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from master.experiment.experiment import Experiment
from master.pages.chart import DOTTED, EVENT, REFERENCE, Chart, Curve, Floats, decimated
from master.pages.picture import save
from master.recording.recorder import Result
from master.stepping.outcome import DIVERGED, Outcome
from master.system.scenario import Condition

from .plots import MILLIMETRES, TIME, charts

MOST_CURVES = 6  # in a chart
MOST_CHARTS = 12
MOST_CHARTS_OF_PICTURE = 6
MOST_POINTS = 300_000  # of all curves, some 1.6 MB in the page
MOST_EVENTS_NAMED = 4
N_DASHES = 100  # of two limits that are one curve: its dashes lie on either in turn

_EARLY = 0.75  # of a diverging run: what comes after it would hide it
_MUCH_LARGER = 4.0
_SAME_SIZE = 30.0  # largest range over the smallest of curves that share a chart
_HAIR = 1e-6  # of the time that is drawn: an event is upright but for it, since times increase


@dataclass(frozen=True)
class RunCharts:
    """Charts of a run; numbers of outputs that want room, and that do not change, and so are not drawn."""

    charts: Sequence[Chart]
    n_left_out: int = 0
    n_constant: int = 0

    @property
    def remark(self) -> str:
        """What is not drawn; empty where all is."""
        said = []
        if self.n_left_out:
            said.append(f"{self.n_left_out} more outputs")
        if self.n_constant:
            said.append(f"{self.n_constant} outputs that do not change")
        return f"not drawn: {' and '.join(said)}" if said else ""


def plot_run(experiment: Experiment, outcome: Outcome, path: Path) -> Path:
    """Draw a run as PNG."""
    drawn = run_charts(experiment, outcome, MOST_CHARTS_OF_PICTURE)
    title = " / ".join(filter(None, (experiment.title, outcome.status)))
    return save("\n".join(filter(None, (title, drawn.remark))), drawn.charts, path)


def run_charts(experiment: Experiment, outcome: Outcome, most: int = MOST_CHARTS) -> RunCharts:
    """Return the charts of a run that has rows, at most a number of them."""
    result = outcome.result
    n_left_out = 0
    n_constant = 0
    found = [] if experiment.compare is None else charts(result, experiment.compare)
    groups = [list(group) for group in experiment.plots]
    if not found and not groups:
        groups, n_constant = _chosen(experiment, result)
        n_left_out = sum(map(len, groups[most:]))
        groups = groups[:most]
    found += [_chart(result, group) for group in groups]
    n_points = sum(len(curve.x) for chart in found for curve in chart.curves)
    marked = [_marked(_scaled(chart, outcome), experiment, outcome) for chart in found]
    if n_points > MOST_POINTS:
        marked = [replace(chart, curves=[decimated(curve) for curve in chart.curves]) for chart in marked]
    return RunCharts(marked, n_left_out, n_constant)


def _chosen(experiment: Experiment, result: Result) -> tuple[list[list[str]], int]:
    """Group the outputs that change, what others depend on first; say how many do not change."""
    moving = [name for name in result.names if _changes(result[name])]
    n_constant = len(result.names) - len(moving) if moving else 0
    watched = {*experiment.limits, *(c.signal for c in _conditions(experiment))}
    wired = {wire.source.name for wire in experiment.system.wires}
    ranked = sorted(moving or result.names, key=lambda name: (name not in watched, name not in wired))
    groups: dict[str, list[list[str]]] = {}
    for name in ranked:
        fitting = (g for g in groups.setdefault(result.unit(name), []) if _fits(result, g, name))
        group = next(fitting, None)
        if group is None:
            groups[result.unit(name)].append([name])
        else:
            group.append(name)
    place = {name: i for i, name in enumerate(ranked)}
    flat = [group for own in groups.values() for group in own]
    return sorted(flat, key=lambda group: place[group[0]]), n_constant


def _conditions(experiment: Experiment) -> list[Condition]:
    return [event.condition for event in experiment.scenario.events if event.condition is not None]


def _changes(values: Floats) -> bool:
    finite = values[np.isfinite(values)]
    return len(finite) < len(values) or bool(np.ptp(finite) > 0.0)


def _fits(result: Result, group: Sequence[str], name: str) -> bool:
    """Whether there is room for a curve in a chart, and none of them would be flat in it."""
    sizes = [_size(result[own]) for own in (*group, name)]
    return len(group) < MOST_CURVES and max(sizes) <= _SAME_SIZE * min(sizes)


def _size(values: Floats) -> float:
    low, high = _range([values])
    return high - low


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
    """Add the limits that the curves come near to, and the times of events."""
    low, high = chart.y_range or _range([curve.y for curve in chart.curves])
    time = outcome.result.time
    marks = [
        mark
        for curve in chart.curves
        if curve.style != REFERENCE
        for mark in _limit_marks(curve.label, chart, experiment, (low, high), time)
    ]
    events = _event_times(experiment, outcome)
    if events and high > low:
        marks.append(_event_marks(events, (low, high), float(time[-1] - time[0])))
    return replace(chart, curves=[*chart.curves, *marks])


def _limit_marks(
    signal: str, chart: Chart, experiment: Experiment, shown: tuple[float, float], time: Floats
) -> list[Curve]:
    """Return the bounds of a signal within the range of a chart: no curve, or one."""
    limit = experiment.limits.get(signal)
    if limit is None:
        return []
    scale = 1e3 if chart.y_label.endswith(MILLIMETRES) else 1.0
    bounds = [bound for bound in (scale * limit, -scale * limit) if shown[0] <= bound <= shown[1]]
    if not bounds:
        return []
    sign = "+-" if len(bounds) == 2 else ""
    unit = chart.y_label.partition("[")[2].rstrip("]")
    value = f"{sign}{bounds[0]:g} {'' if unit == '1' else unit}".rstrip()
    label = f"limit {value} of {signal}"
    if len(bounds) == 1:
        return [Curve(label, time[[0, -1]], np.full(2, bounds[0]), DOTTED, signal)]
    begins = np.linspace(time[0], time[-1], N_DASHES, endpoint=False)
    length = float(time[-1] - time[0]) / N_DASHES
    x = np.column_stack([begins, begins + 0.9 * length, begins + 0.95 * length])
    y = np.column_stack(
        [np.resize(bounds, (N_DASHES, 1)), np.resize(bounds, (N_DASHES, 1)), np.full(N_DASHES, np.nan)]
    )
    return [Curve(label, x.ravel(), y.ravel(), DOTTED, signal)]


def _event_times(experiment: Experiment, outcome: Outcome) -> list[tuple[float, str]]:
    """Return times [s] and texts of the events that a run came to, in the order of time."""
    time = outcome.result.time
    at = [event.at for event in experiment.config.events if event.at is not None]
    found = [(t, f"{t:g} s") for t in at if time[0] <= t <= time[-1]]
    found += [(h.t, f"{h.t:g} s, {h.condition}") for h in outcome.happened]
    return sorted(set(found))


def _event_marks(events: Sequence[tuple[float, str]], shown: tuple[float, float], span: float) -> Curve:
    """Return upright lines at the times of events, as one curve that its label explains."""
    x: list[float] = []
    y: list[float] = []
    hair = _HAIR * max(span, 1e-9)
    for t, _ in events:
        if x and t <= x[-1]:
            continue  # at the same time as the one before it
        x += [t, t + hair, t + 2.0 * hair]
        y += [*shown, np.nan]
    texts = [text for _, text in events]
    named = "; ".join(texts[:MOST_EVENTS_NAMED])
    if len(texts) > MOST_EVENTS_NAMED:
        named += f"; and {len(texts) - MOST_EVENTS_NAMED} more"
    label = f"event at {named}" if len(texts) == 1 else f"events at {named}"
    return Curve(label, np.array(x), np.array(y), EVENT)
