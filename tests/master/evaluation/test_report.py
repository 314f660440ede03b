import json
import signal
from dataclasses import replace

import pytest

from master.api import prepare_to_run
from master.evaluation import report as report_module
from master.evaluation.report import save_run, summary_lines
from master.process.signals import Interruption
from master.recording.folder import OutputFolder
from master.stepping import simulate
from master.stepping.outcome import RunOptions

TEXT = """\
name: test
step_size: 0.5
stop_time: 4.0
fmus:
  mass: {source: growing.fmu}
  bad: {source: failing.fmu}
compare: {signal: mass.y, offset: 0.01}
"""


@pytest.fixture
def saved(bay):
    """Save a run of TEXT with some words replaced; give the report and the outcome."""

    def run(*replaced):
        text = TEXT
        for old, new in replaced:
            text = text.replace(old, new)
        experiment = prepare_to_run(bay.write(text))
        options = RunOptions(limits=experiment.limits)
        outcome = simulate.simulate(
            experiment.system, experiment.schedule, experiment.grid, options=options, compiled=False
        )
        with OutputFolder(bay.folder / "out") as folder:
            return save_run(experiment, outcome, folder), outcome

    return run


def test_a_failed_run_saves_its_rows_and_says_why(saved, bay):
    report, _ = saved(("offset: 0.01", "offset: 1e6"))

    assert (report.status, report.steps, report.t_end) == ("failed", 6, 3.0)
    assert report.message == "bad at t=3 s: rope torn"
    assert len((bay.folder / "out" / "result.csv").read_text(encoding="utf-8").splitlines()) == 8


def test_a_condition_that_did_not_come_true_is_in_the_summary(saved):
    report, outcome = saved()
    report = replace(report, not_reached=["mass.y > 1e+09"])

    assert "not_reached" in report.as_dict()
    assert outcome.not_reached == []
    [line] = [line for line in summary_lines(report) if "mass.y" in line]
    assert line.split("  ")[1] == "an event that did not happen: when"
    assert line.endswith(" mass.y > 1e+09")


def test_a_diverged_run_says_which_signal(saved):
    report, _ = saved()

    assert (report.status, report.steps) == ("diverged", 1)
    assert report.message == "diverged: mass.y: got 2 m, expected a magnitude of at most 1 m"


def test_the_folder_holds_every_file_that_the_report_names(saved, bay):
    report, _ = saved()

    assert set(report.files) == {"csv", "parquet", "plot", "summary"}
    assert sorted(p.name for p in (bay.folder / "out").iterdir()) == sorted(
        file.rpartition("/")[2] for file in report.files.values()
    )


def test_the_summary_file_is_the_report(saved):
    report, _ = saved()

    with open(report.files["summary"], encoding="utf-8") as file:
        assert json.load(file) == report.as_dict()


def test_without_a_comparison_there_is_a_picture_and_no_metric(saved, bay):
    report, _ = saved(("compare: {signal: mass.y, offset: 0.01}\n", ""))

    assert report.metrics == {}
    assert (bay.folder / "out" / "plots.png").read_bytes().startswith(b"\x89PNG")
    assert report.files["plot"] == str(bay.folder / "out" / "plots.png")


def test_an_empty_list_of_plots_draws_nothing(saved):
    report, _ = saved(("compare:", "plots: []\ncompare:"))

    assert "plot" not in report.files
    assert "zeta" in report.metrics


def test_speed_is_time_per_step_and_simulated_time_over_time(saved, bay):
    _, outcome = saved(("offset: 0.01", "offset: 1e6"))
    experiment = prepare_to_run(bay.folder / "system.yaml")
    with OutputFolder(bay.folder / "out") as folder:
        report = save_run(experiment, replace(outcome, seconds=0.012), folder)

    assert report.us_per_step == pytest.approx(2000.0)
    assert report.realtime_factor == pytest.approx(3.0 / 0.012)


def test_the_summary_has_a_line_for_each_number_and_file(saved):
    report, _ = saved(("offset: 0.01", "offset: 1e6"))
    known = replace(
        report, variant="big", us_per_step=2.0, realtime_factor=500.0, metrics={"zeta": 0.0123456}
    )
    lines = summary_lines(replace(known, files={"csv": "out/result.csv"}))

    assert lines == [
        "test, variant big: failed at t = 3 s after 6 steps",
        f"  {'speed':<54}2.0 us a step, 500.0 times real time",
        f"  {'damping ratio zeta':<54}0.012346",
        f"  {'csv':<54}out/result.csv",
    ]


def test_a_metric_that_could_not_be_computed_is_a_dash(saved):
    report, _ = saved()

    assert f"  {'frequency [Hz]':<54}-" in summary_lines(report)


def test_a_signal_while_the_picture_is_drawn_makes_the_run_an_interrupted_one(bay, monkeypatch):
    interruption = Interruption()
    draw = report_module.plot_run

    def draw_and_interrupt(*arguments):
        interruption.note(signal.SIGTERM)
        return draw(*arguments)

    monkeypatch.setattr(report_module, "plot_run", draw_and_interrupt)
    text = TEXT.replace("  bad: {source: failing.fmu}\n", "").replace("offset: 0.01", "offset: 1e6")
    experiment = prepare_to_run(bay.write(text))
    outcome = simulate.simulate(experiment.system, experiment.schedule, experiment.grid, compiled=False)
    with OutputFolder(bay.folder / "out") as folder:
        report = save_run(experiment, outcome, folder, interruption=interruption)

    assert (outcome.status, report.status) == ("completed", "interrupted")
    assert json.loads((bay.folder / "out" / "summary.json").read_text())["status"] == "interrupted"
