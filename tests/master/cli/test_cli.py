import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from master.cli import main
from tests.stubs import Block, variables

PROJECT = Path(__file__).parents[3]

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
variants:
  big: {mass: {size: 5}}
"""
LOOP = TEXT.replace("clock: {source: clock.fmu}", "clock: {source: gain.fmu, every: 2}").replace(
    "  - {from: clock.t, to: mass.u}", "  - {from: clock.y, to: mass.u}\n  - {from: mass.x, to: clock.u}"
)


@pytest.fixture
def dockloop(bay):
    """Call the command on a text; results go to the folder `out`."""

    def call(command, text=TEXT, *options):
        more = ("--output", str(bay.folder / "out")) if command == "run" else ()
        result = CliRunner().invoke(main, [command, str(bay.write(text)), *more, *options])
        assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
        return result

    return call


def failing(text):
    return text.replace("clock.fmu", "failing.fmu")


def diverging(text):
    return text + "limits:\n  clock.t: 5\n"


def test_a_completed_run_has_status_0_and_a_summary(dockloop):
    result = dockloop("run")

    assert result.exit_code == 0
    assert result.stdout.startswith("test: completed at t = 20 s after 40 steps\n")


@pytest.mark.parametrize(
    ("change", "code", "status", "steps"),
    [(str, 0, "completed", 40), (failing, 3, "failed", 6), (diverging, 4, "diverged", 11)],
)
def test_the_exit_status_says_how_a_run_ended(dockloop, bay, change, code, status, steps):
    result = dockloop("run", change(TEXT), "--json")
    answer = json.loads(result.stdout)

    assert (result.exit_code, answer["status"], answer["steps"]) == (code, status, steps)
    assert len((bay.folder / "out" / "result.csv").read_text(encoding="utf-8").splitlines()) == steps + 2


def test_json_is_one_object_with_the_promised_keys(dockloop):
    answer = json.loads(dockloop("run", TEXT, "--json", "--variant", "big").stdout)

    assert {"name", "variant", "status", "t_end", "steps", "us_per_step", "realtime_factor"} <= set(answer)
    assert {"files", "metrics"} <= set(answer)
    assert (answer["name"], answer["variant"], answer["t_end"]) == ("test", "big", 20.0)


def test_json_has_the_promised_metrics_where_there_is_a_comparison(dockloop):
    text = TEXT + "compare: {signal: mass.x, offset: 10.0}\n"
    metrics = json.loads(dockloop("run", text, "--json").stdout)["metrics"]

    assert {"zeta", "frequency", "growth_per_cycle", "rms_s_des", "rms_s_act", "phase_deg"} <= set(metrics)


def test_ctrl_c_saves_what_was_computed_and_has_status_130(dockloop, bay):
    bay.interrupt = lambda: signal.raise_signal(signal.SIGINT)
    text = TEXT.replace("clock.fmu", "interrupting.fmu").replace("stop_time: 20.0", "stop_time: 1e5")
    result = dockloop("run", text, "--json")
    answer = json.loads(result.stdout)

    assert (result.exit_code, answer["status"]) == (130, "interrupted")
    rows = (bay.folder / "out" / "result.csv").read_text(encoding="utf-8").splitlines()
    assert 20 < answer["steps"] == len(rows) - 2 < 200_000


def test_faults_are_written_to_standard_error_with_status_2(dockloop, bay):
    result = dockloop("run", TEXT.replace("size: 1.0", "size: .nan, sise: 1"))

    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.count(f"{bay.folder}/system.yaml:6: fmus.mass.parameters.") == 2
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize("command", ["run", "check", "explain"])
def test_faults_in_json_are_one_object(dockloop, command):
    result = dockloop(command, TEXT.replace("name:", "nam:"), "--json")
    answer = json.loads(result.stdout)

    assert (result.exit_code, answer["status"], len(answer["problems"])) == (2, "failed", 2)


def test_initial_values_that_do_not_settle_have_status_3(dockloop):
    text = LOOP.replace("gain.fmu", "adding.fmu").replace(
        "integrator.fmu, parameters: {size: 1.0}", "gain.fmu"
    )
    result = dockloop("run", text.replace("mass.x", "mass.y").replace("big: {mass: {size: 5}}", "none: {}"))

    assert (result.exit_code, result.stdout) == (3, "")
    assert "initial values do not settle" in result.stderr
    assert "Traceback" not in result.stderr


def test_check_counts_what_is_in_a_valid_file(dockloop, bay):
    result = dockloop("check")

    assert result.exit_code == 0
    assert result.stdout == (
        f"{bay.folder}/system.yaml: valid, 2 fmus, 1 connections, 1 variants, 40 steps\n"
    )


@pytest.mark.parametrize("factor", ["nan", "inf", "0"])
def test_a_pace_that_no_clock_keeps_is_refused(dockloop, factor):
    result = dockloop("run", TEXT, "--real-time", factor)

    assert result.exit_code == 2
    assert "Invalid value for '--real-time'" in result.stderr


def test_check_answers_in_json(dockloop):
    assert json.loads(dockloop("check", TEXT, "--json").stdout) == {
        "name": "test",
        "status": "valid",
        "fmus": 2,
        "connections": 1,
        "variants": 1,
        "steps": 40,
        "notes": [],
    }


def test_check_tells_of_an_algebraic_loop_that_the_order_does_not_solve(dockloop, bay):
    text = """\
name: ring
stop_time: 1.0
fmus: {a: {source: gain.fmu}, b: {source: gain.fmu}}
connections: [{from: a.y, to: b.u}, {from: b.y, to: a.u}]
coupling: {order: [a, b]}
"""
    loop = "a.y -> b.u -> b.y -> a.u -> a.y: not solved within a step, b.y -> a.u is 1 step old"

    assert dockloop("check", text).stdout.splitlines()[1:] == [f"note: algebraic loop {loop}"]
    solved = text.replace("[a, b]}", "[{iterate: [a, b]}]}")
    assert len(dockloop("check", solved).stdout.splitlines()) == 1


def test_explain_says_order_delay_and_that_there_is_no_loop(dockloop):
    lines = dockloop("explain").stdout.splitlines()

    assert lines[:3] == ["test: one tick is 500 ms, stepped in this order", "  1. mass", "  2. clock"]
    assert any(line.split() == ["clock.t", "->", "mass.u", "1", "500.000"] for line in lines)
    assert lines[-1] == "No loops."


def test_explain_shows_rates_ranges_and_loops(dockloop):
    text = dockloop("explain", LOOP).stdout

    assert "  2. clock   every 2 ticks\n" in text
    assert "1..2" in text
    assert "Loops: the sum of the delays once around\n" in text


def test_explain_in_json_holds_order_connections_and_loops(dockloop):
    answer = json.loads(dockloop("explain", LOOP, "--json").stdout)

    assert answer["order"] == [["mass"], ["clock"]]
    ages = [(c["from"], c["to"], c["least_steps"], c["most_steps"]) for c in answer["connections"]]
    assert ages == [("clock.y", "mass.u", 1, 2), ("mass.x", "clock.u", 0, 0)]
    assert [(loop["steps"], loop["seconds"]) for loop in answer["loops"]] == [(1.5, 0.75)]


def test_explain_takes_a_variant_and_assignments(dockloop):
    assert dockloop("explain", TEXT, "--variant", "big", "--set", "mass.count=2").exit_code == 0
    assert dockloop("explain", TEXT, "--variant", "small").exit_code == 2


def test_explain_shows_a_name_that_would_turn_the_line_around_as_an_escape(dockloop, bay):
    bay.made["odd"] = Block(lambda t, h, v: {"y\u202e": t}, variables(("y\u202e", "output")))
    (bay.folder / "odd.fmu").touch()
    text = TEXT.replace("clock.fmu", "odd.fmu").replace("clock.t", '"clock.y\u202e"')
    result = dockloop("explain", text)

    assert result.exit_code == 0, result.output
    assert "clock.y\\u202e -> mass.u" in result.stdout
    assert "\u202e" not in result.stdout


def test_an_unknown_model_cannot_be_built():
    result = CliRunner().invoke(main, ["build", "spacecraff"])

    assert result.exit_code == 2
    assert result.stderr.startswith("MODEL: no such model, got 'spacecraff', expected 'spacecraft' (of ")


@pytest.mark.parametrize("command", ["run", "check", "explain", "build"])
def test_every_command_has_a_help_text(command):
    result = CliRunner().invoke(main, [command, "--help"])

    assert result.exit_code == 0
    assert "Usage:" in result.stdout


def test_the_module_is_the_command_and_its_exit_status_reaches_the_shell(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "master", "check", "none.yaml", "--json"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(PROJECT)},
        capture_output=True,
        text=True,
    )

    assert done.returncode == 2
    assert json.loads(done.stdout)["problems"] == [
        "none.yaml: cannot be read, got No such file or directory, expected a YAML file"
    ]
    assert "Traceback" not in done.stderr
