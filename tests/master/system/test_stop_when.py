"""`stop_when`: a condition that ends the run, with its status, cause and exit status."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from dockloop import load
from master.cli import main
from master.errors import ConfigError
from master.system.config import Config, LoadedConfig
from master.system.scenario import make_scenario
from tests.stubs import Block, bench, clock, variables


def stopping(made, conditions, **more):
    config = made.loaded.config.model_dump(by_alias=True) | {
        "stop_when": conditions,
        "stop_time": 100.0,
        **more,
    }
    return make_scenario(LoadedConfig(Config.model_validate(config), made.loaded.document), made.system)


def test_a_run_ends_at_the_tick_after_which_a_condition_is_true():
    made = bench({"clock": clock()})

    for compiled in (False, True):
        outcome = made.run(9, scenario=stopping(made, "clock.t > 3.5"), compiled=compiled)
        assert (outcome.status, outcome.steps) == ("stopped", 4)
        assert outcome.result["clock.t"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
        assert outcome.cause == "stop_when clock.t > 3.5 at t=4 s: clock.t 4"


def test_a_signal_alone_ends_the_run_where_it_is_above_0():
    blocks = {"a": Block(lambda t, h, v: {"y": float(t >= 2.0)}, variables(("y", "output")))}
    made = bench(blocks)

    outcome = made.run(9, scenario=stopping(made, ["a.y < -1", "a.y"]))

    assert (outcome.status, outcome.steps) == ("stopped", 3)


def test_a_condition_that_is_true_at_the_start_ends_the_run_before_its_first_step():
    made = bench({"clock": clock()})

    outcome = made.run(9, scenario=stopping(made, "clock.t < 0.5"))

    assert (outcome.status, outcome.steps) == ("stopped", 0)


def test_without_its_condition_a_run_completes_and_says_nothing():
    made = bench({"clock": clock()})

    outcome = made.run(9, scenario=stopping(made, "clock.t > 50"))

    assert (outcome.status, outcome.cause, outcome.not_reached) == ("completed", "", [])


def test_events_with_conditions_keep_their_place_next_to_it():
    blocks = {
        "clock": clock(),
        "g": Block(lambda t, h, v: {"y": v["u"]}, variables(("u", "input"), ("y", "output")), {"y": ("u",)}),
    }
    made = bench(blocks)
    events = [{"when": "clock.t > 90", "set": {"g.u": 1.0}}, {"when": "clock.t > 1.5", "set": {"g.u": 7.0}}]

    outcome = made.run(9, scenario=stopping(made, "clock.t > 4.5", events=events))

    assert outcome.result["g.y"].tolist() == [0.0, 0.0, 0.0, 7.0, 7.0, 7.0]
    assert outcome.not_reached == ["clock.t > 90"]


@pytest.mark.parametrize(
    ("condition", "problem"),
    [
        ("clock.x", "no such output of clock (clock), got 'x', expected one of t"),
        ("clock.t > x", "not a number, got 'x', expected a threshold"),
        ("clock.t > nan", "not a number, got 'nan', expected a threshold"),
        ("clock", "not a signal, got 'clock', expected 'instance.variable'"),
    ],
)
def test_a_fault_of_a_condition_is_named(condition, problem):
    made = bench({"clock": clock()})

    with pytest.raises(ConfigError) as caught:
        stopping(made, ["clock.t > 2", condition])
    assert [p.partition("stop_when[1]: ")[2] for p in caught.value.problems] == [problem]


def run(tmp_path, *options):
    out = ["--output", str(tmp_path / "out"), "--json"]
    answer = CliRunner().invoke(main, ["run", "configs/guarded.yaml", *options, *out])
    return answer.exit_code, json.loads(answer.stdout)


def test_the_shipped_guard_ends_a_run_that_would_diverge(tmp_path):
    """Without compensation: alarm within 0.3 cycles of 0.875 Hz, before the motion exceeds its start."""
    exit_status, report = run(tmp_path, "--variant", "none", "--page")

    assert (exit_status, report["status"]) == (5, "stopped")
    assert report["t_end"] < 0.3 / 0.875
    assert "guard.reason 1," in report["message"]
    assert "<code>guard.alarm</code>" in (tmp_path / "out" / "run.html").read_text(encoding="utf-8")

    exit_status, report = run(tmp_path, "--variant", "unguarded")
    assert (exit_status, report["status"]) == (4, "diverged")


def test_a_guard_that_sees_nothing_leaves_the_bits_of_the_run():
    plain = load("experiment_1000kg").run()
    guarded = load("guarded").run()

    assert guarded.status == "completed"
    for signal in ("spacecraft.s_des", "motion_simulator.s_act", "force_sensor.f_mea"):
        assert (plain[signal] == guarded[signal]).all()


def test_events_may_switch_to_safe_values_instead(tmp_path):
    """The alarm turns the spacecraft's mass into a large one, and the run goes on to its end."""
    text = Path("configs/guarded.yaml").read_text(encoding="utf-8")
    event = "events: [{when: guard.alarm > 0.5, set: {spacecraft.m_s: 1e9}}]"
    file = tmp_path / "guarded.yaml"
    file.write_text(text.replace("stop_when: guard.alarm", event), encoding="utf-8")

    outcome = load(file).run(variant="none")

    assert outcome.status == "completed"
    rows = outcome["guard.alarm"] > 0.5
    assert abs(outcome["spacecraft.v_des"][rows]).max() < 0.03
    assert (outcome["guard.f_safe"][rows] == 0.0).all()
