"""Runs that end their process, never end or are killed: each has one row, with the right status."""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow.dataset as pads
import pytest
from click.testing import CliRunner

from master.campaign.plan import make_plan
from master.campaign.sweep import sweep
from master.cli import main
from master.errors import ConfigError, DataError
from tests.foreign.build import FOLDERS, compile_c, write_fmu

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="runs are not forked here"),
]

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="rude" guid="rude">
  <CoSimulation modelIdentifier="rude"/>
  <ModelVariables>
    <ScalarVariable name="p" valueReference="0" causality="parameter" variability="fixed">
      <Real start="0"/>
    </ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="2" dependencies=""/></Outputs></ModelStructure>
</fmiModelDescription>
"""
SYSTEM = """\
name: rude
step_size: 0.1
stop_time: 1.0
fmus: {rude: {source: rude.fmu}}
"""
CAMPAIGN = """\
system: system.yaml
vary: {{rude.p: {vary}}}
keep: {{measures: {{y: {{final: rude.y}}}}}}
time_limit: {limit}
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return compile_c("2.0", tmp_path_factory.mktemp("rude"), Path(__file__).with_name("rude2.c"))


@pytest.fixture
def write(library, tmp_path):
    """Write a campaign of the rude FMU."""
    write_fmu(tmp_path / "rude.fmu", DESCRIPTION, {f"{FOLDERS['2.0']}/rude.so": library})

    def campaign(vary, *, limit=60.0):
        (tmp_path / "system.yaml").write_text(SYSTEM)
        path = tmp_path / "campaign.yaml"
        path.write_text(CAMPAIGN.format(vary=vary, limit=limit))
        return path

    return campaign


def rows(folder):
    return pads.dataset(folder / "runs").to_table().to_pydict()


def test_runs_that_crash_hang_or_fail_have_their_status_and_the_others_go_on(write, tmp_path):
    p = [1.0, 2.0, 1.5, 3.0, 4.0, 0.5, 2.5, 1.0]
    plan = make_plan(write(f"{{values: {p}}}", limit=4.0))
    found = sweep(plan, tmp_path / "out", 2, page=False)
    table = rows(tmp_path / "out")
    by_run = dict(
        zip(table["run"], zip(table["status"], table["y"], table["message"], strict=True), strict=True)
    )

    assert sorted(table["run"]) == list(range(8))
    assert [by_run[run][0] for run in range(8)] == [
        "completed", "crashed", "completed", "timed_out", "failed", "completed", "crashed", "completed",
    ]  # fmt: skip
    assert by_run[1][2] == "rude at t=0.4 s: ended the process, killed by SIGSEGV, in fmi2DoStep"
    assert by_run[3][2] == "took more than the time limit of 4 s in rude, fmi2DoStep"
    assert by_run[2][1] == pytest.approx(1.5)
    assert by_run[1][1] is None
    assert found.statuses == {"completed": 4, "crashed": 2, "failed": 1, "timed_out": 1}


@contextmanager
def killing(n: int):
    """Kill n workers of this process at random moments; yields those that were killed."""
    killed: list[str] = []
    children = Path(f"/proc/self/task/{os.getpid()}/children")
    of_other_tests = children.read_text().split()
    over = threading.Event()
    pauses = np.random.default_rng(1)

    def kill():
        while not over.is_set():
            time.sleep(pauses.uniform(0.02, 0.2))
            workers = [
                child for child in children.read_text().split() if child not in [*of_other_tests, *killed]
            ]
            if workers and len(killed) < n:
                os.kill(int(workers[0]), signal.SIGKILL)
                killed.append(workers[0])

    thread = threading.Thread(target=kill)
    thread.start()
    try:
        yield killed
    finally:
        over.set()
        thread.join()


@pytest.mark.long
def test_a_worker_that_is_killed_costs_no_run_and_doubles_none(write, tmp_path):
    plan = make_plan(write("{linspace: [-1.9, -0.1, 400]}"))
    with killing(20) as killed:
        found = sweep(plan, tmp_path / "out", 2, page=False)
    table = rows(tmp_path / "out")

    assert len(killed) == 20
    assert 0 < found.restarts <= 20  # a worker that is killed when nothing is left to do is not replaced
    assert sorted(table["run"]) == list(range(400))
    assert set(table["status"]) == {"completed"}


@pytest.mark.long
def test_of_two_thousand_runs_those_that_crash_or_hang_have_their_status_while_workers_are_killed(
    write, tmp_path
):
    p = np.linspace(-1.9, -0.1, 2000)
    drawn = np.random.default_rng(23).permutation(2000)
    p[drawn[:20]] = 2.0  # 1 % end their process
    p[drawn[20:22]] = 3.0  # 0.1 % never return
    plan = make_plan(write(f"{{values: {p.tolist()}}}", limit=5.0))
    with killing(20) as killed:
        found = sweep(plan, tmp_path / "out", 2, page=False)
    table = rows(tmp_path / "out")
    by_run = dict(zip(table["run"], table["status"], strict=True))

    assert len(killed) == 20
    assert found.statuses == {"completed": 1978, "crashed": 20, "timed_out": 2}
    assert len(table["run"]) == len(by_run) == 2000
    assert {run for run, status in by_run.items() if status == "crashed"} == {*drawn[:20].tolist()}
    assert {run for run, status in by_run.items() if status == "timed_out"} == {*drawn[20:22].tolist()}


def test_a_campaign_goes_on_where_it_ended_and_takes_no_other_campaign(write, tmp_path):
    path = write("{linspace: [0.0, 1.9, 40]}")
    out = tmp_path / "out"
    sweep(make_plan(path), out, 1, page=False)
    [part] = sorted((out / "runs").glob("*.parquet"))[-1:]
    gone = pads.dataset(part).to_table()["run"].to_pylist()
    part.unlink()
    with pytest.raises(DataError, match="holds a campaign already, expected --resume or another folder"):
        sweep(make_plan(path), out, 1, page=False)
    found = sweep(make_plan(path), out, 1, resume=True, page=False)

    assert gone
    assert found.runs == 40
    assert sorted(rows(out)["run"]) == list(range(40))
    other = write("{linspace: [0.0, 1.8, 40]}")
    with pytest.raises(ConfigError, match="another campaign"):
        sweep(make_plan(other), out, 1, resume=True, page=False)


def test_ctrl_c_keeps_the_rows_and_resume_makes_the_rest(write, tmp_path):
    path = write("{linspace: [-1.9, -0.1, 150]}")
    out = tmp_path / "out"
    timer = threading.Timer(0.8, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    found = sweep(make_plan(path), out, 1, page=False)
    timer.join()

    assert found.ended == "interrupted"
    assert found.interruption == signal.SIGINT
    again = sweep(make_plan(path), out, 1, resume=True, page=False)
    assert sorted(rows(out)["run"]) == list(range(150))
    assert again.statuses == {"completed": 150}


def test_a_campaign_ends_early_where_the_interval_is_narrow(write, tmp_path):
    path = write("{uniform: [0.0, 1.0]}")
    text = (
        path.read_text() + "design: {method: random, size: 100000}\nuntil: {measure: y, half_width: 0.05}\n"
    )
    path.write_text(text)
    found = sweep(make_plan(path), tmp_path / "out", 1, page=False)

    assert 100 <= found.runs < 2000
    assert found.interval["value"] == pytest.approx(0.5, abs=0.1)
    assert 0.5 * (found.interval["high"] - found.interval["low"]) <= 0.05


def test_the_command_prints_what_it_did_and_writes_a_page_with_commands_that_repeat_runs(write, tmp_path):
    path = write("{values: [1.0, 1.5, 2.5]}")
    out = tmp_path / "out"
    done = CliRunner().invoke(main, ["sweep", str(path), "--workers", "1", "--output", str(out), "--json"])
    told = json.loads(done.stdout)
    page = (out / "campaign.html").read_text(encoding="utf-8")

    assert done.exit_code == 0
    assert {"runs", "statuses", "wall_s", "stepping_share", "dataset", "page"} <= set(told)
    assert told["statuses"] == {"completed": 2, "crashed": 1}
    assert f"dockloop run {tmp_path / 'system.yaml'} --set rude.p=2.5" in page
    assert np.isclose(max(y for y in rows(out)["y"] if y is not None), 1.5)


def test_a_tuned_campaign_ends_at_the_bound_that_a_constraint_sets(write, tmp_path):
    (tmp_path / "own.py").write_text(
        "def miss(time, signals):\n    return (signals['rude.y'][-1] - 1.2) ** 2\n"
    )
    path = write("{values: [0.0]}")
    path.write_text(
        path.read_text().partition("vary")[0]
        + "keep: {measures: {y: {final: rude.y}, miss: {function: 'own.py:miss'}}}\n"
        + "tune:\n  values: {rude.p: [0.0, 1.9]}\n  minimise: miss\n"
        + "  constraints: [{measure: y, at_most: 1.0}]\n  population: 8\n  generations: 12\n"
    )
    found = sweep(make_plan(path), tmp_path / "out", 1)

    assert found.tuned["values"]["rude.p"] == pytest.approx(1.0, abs=0.01)  # y = p after 1 s
    assert found.tuned["is_feasible"]
    assert rows(tmp_path / "out")["y"] == [pytest.approx(1.0, abs=0.01)]
