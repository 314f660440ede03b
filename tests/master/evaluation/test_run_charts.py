"""What a run draws: which signals share a chart, what is marked, how a diverging run is scaled."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from master.api import prepare_to_run
from master.evaluation.run_charts import MOST_CHARTS_OF_PICTURE, RunCharts, plot_run, run_charts
from master.pages.palette import DARK, LIGHT
from master.recording.recorder import Result
from master.stepping.outcome import Happened, Outcome
from tests.master.pages.sight import apart

TEXT = """\
name: test
step_size: 0.5
stop_time: 20.0
fmus:
  clock: {source: clock.fmu}
  mass: {source: integrator.fmu, parameters: {size: 1.0}}
coupling: {order: [mass, clock]}
connections:
  - {from: clock.t, to: mass.u}
"""
TIME = np.linspace(0.0, 20.0, 41)


def drawn(bay, columns, more="", status="completed", units=None, most=12, **outcome) -> RunCharts:
    """Charts of a run that gave these columns, by name."""
    experiment = prepare_to_run(bay.write(TEXT + more))
    units = units or dict.fromkeys(columns, "m")
    rows = Result(TIME, tuple(columns), tuple(units.values()), np.column_stack([*columns.values()]))
    return run_charts(experiment, Outcome(status, rows, 1.0, 40, **outcome), most)


def labels(found: RunCharts):
    return [[c.label for c in chart.curves] for chart in found.charts]


def test_outputs_of_one_unit_and_size_share_a_chart_those_that_are_wired_first(bay):
    found = drawn(
        bay,
        {"a.far": 1e3 * TIME, "a.near": TIME, "a.rest": 0.0 * TIME, "clock.t": 2.0 * TIME, "a.f": TIME},
        units={"a.far": "m", "a.near": "m", "a.rest": "m", "clock.t": "m", "a.f": "N"},
    )

    assert labels(found) == [["clock.t", "a.near"], ["a.far"], ["a.f"]]
    assert found.remark == "not drawn: 1 outputs that do not change"


def test_more_than_six_curves_or_a_few_charts_are_not_drawn_and_said(bay):
    columns = {f"a.x{i}": TIME + i for i in range(13)}

    assert [len(own) for own in labels(drawn(bay, columns))] == [6, 6, 1]
    few = drawn(bay, columns, most=2)
    assert (len(few.charts), few.remark) == (2, "not drawn: 1 more outputs")
    assert MOST_CHARTS_OF_PICTURE <= 6


def test_where_nothing_changes_all_is_drawn(bay):
    assert labels(drawn(bay, {"a.x": 0.0 * TIME, "a.y": 0.0 * TIME})) == [["a.x", "a.y"]]


def test_compared_motions_and_asked_for_plots_are_both_drawn(bay):
    more = "compare: {signal: mass.x, offset: 1.0}\nplots: [[clock.t]]\n"

    assert labels(drawn(bay, {"clock.t": TIME, "mass.x": TIME}, more)) == [["mass.x"], ["clock.t"]]
    assert labels(drawn(bay, {"clock.t": TIME, "mass.x": TIME}, more[39:])) == [["clock.t"]]


def test_events_and_limits_within_the_range_are_marked(bay):
    more = "limits: {clock.t: 15, mass.x: 99}\nevents: [{at: 5.0, for: 1, freeze: mass.u}]\n"
    [own] = labels(drawn(bay, {"clock.t": TIME, "mass.x": TIME}, more))

    assert own[2:] == ["limit 15 m of clock.t", "event at 5 s"]


def test_two_limits_are_one_curve_that_lies_on_both(bay):
    found = drawn(bay, {"clock.t": 2.0 * TIME - 20.0}, "limits: {clock.t: 15}\n")
    [_, limit] = found.charts[0].curves

    assert limit.label == "limit +-15 m of clock.t"
    assert {*limit.y[np.isfinite(limit.y)]} == {15.0, -15.0}
    assert np.all(np.diff(limit.x) > 0.0)


def test_a_condition_that_came_true_is_marked_at_its_time(bay):
    more = "events: [{at: 15.0, freeze: mass.u}, {when: clock.t > 7, drop: mass.u}]\n"
    found = drawn(bay, {"clock.t": TIME}, more, happened=[Happened("clock.t > 7", 7.5)])
    [_, event] = found.charts[0].curves

    assert event.label == "events at 7.5 s, clock.t > 7; 15 s"
    assert event.x[[0, 3]].tolist() == [7.5, 15.0]
    assert np.all(np.diff(event.x) > 0.0)


def test_a_limit_in_metres_is_marked_on_a_chart_in_millimetres(bay):
    more = "compare: {signal: mass.x, offset: 1e-5}\nlimits: {mass.x: 0.005}\n"
    found = drawn(bay, {"mass.x": 0.01 * np.sin(TIME)}, more)

    assert found.charts[0].curves[1].label == "limit +-5 mm of mass.x"


@pytest.mark.parametrize("more", ["", "compare: {signal: clock.t, offset: 1.0}\n"])
def test_a_diverging_run_is_scaled_to_its_first_three_quarters(bay, more):
    found = drawn(bay, {"clock.t": np.exp(TIME)}, more, status="diverged")
    early = float(np.exp(TIME[29]))  # the last of 30 rows; the first is 1
    room = 0.5 * (early - 1.0)

    assert found.charts[0].y_range == pytest.approx((1.0 - room, early + room))


@pytest.mark.parametrize("colours", [LIGHT, DARK], ids=["light", "dark"])
def test_any_two_curves_of_a_chart_are_told_apart_without_seeing_green(bay, colours):
    columns = {f"a.x{i}": TIME + i for i in range(40)} | {"clock.t": 2.0 * TIME - 20.0}
    more = "limits: {clock.t: 15}\nevents: [{at: 5.0, freeze: mass.u}]\n"
    found = drawn(bay, columns, more)
    pairs = [
        (one, other)
        for chart in found.charts
        for one, other in itertools.combinations(zip(chart.curves, chart.looks, strict=True), 2)
    ]

    assert len(pairs) > 90
    assert [(a[0].label, b[0].label) for a, b in pairs if not apart(a, b, colours)] == []


def test_the_picture_of_a_run_is_a_file(bay, tmp_path):
    experiment = prepare_to_run(bay.write(TEXT))
    rows = Result(TIME, ("clock.t",), ("s",), TIME[:, None])
    path = plot_run(experiment, Outcome("completed", rows, 1.0, 40), tmp_path / "plots.png")

    assert path.read_bytes().startswith(b"\x89PNG")
