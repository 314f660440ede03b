"""Where the system cannot fork, a command does all in its own process and says the same; `sweep` refuses."""

import json
import os
import re
from types import SimpleNamespace

import pytest
from click.testing import CliRunner

from master.cli import main
from master.diagnosis.replay import candidate_models
from master.diagnosis.replay.candidate_models import ModelPool
from master.errors import ConfigError
from master.installation import CONFIG_FOLDER
from master.process import child
from master.stepping import apart

CAMPAIGN = """\
system: experiment
variant: cfdc_fmdc
stop_time: 0.3
vary:
  spacecraft.m_s: {uniform: [400, 900]}
  force_sensor.T_f: {normal: [10, 1], unit: ms, bounds: [5, 15]}
design: {method: sobol, size: 4, seed: 1}
keep: {metrics: all}
"""
COMMANDS = [
    "run low_frequency --stop-time 0.3 --page --output out",
    "analyse low_frequency",
    "analyse varying.yaml --variant dpdc",
    "preflight low_frequency",
    "commission experiment_1000kg --output parameters.ssv",
    "compare-methods low_frequency --methods virtual_damper --seeds 1",
    "rths --method inverse3",
    "design-dpdc low_frequency",
    "diagnose first_case --output out",
    "replay first_case",
    "reproduce --only 17 --only ideal --output out",
    "check low_frequency",
]
OF_THE_MOMENT = {"us_per_step", "realtime_factor", "wall_s", "stepping_share"}


def result_of(command, folder, monkeypatch):
    folder.mkdir()
    varying = (CONFIG_FOLDER / "time_varying_stiffness.yaml").read_text()
    (folder / "varying.yaml").write_text(re.sub("stop_time: .*", "stop_time: 1.0", varying))
    monkeypatch.chdir(folder)
    done = CliRunner().invoke(main, [*command.split(), "--json"])
    assert done.exit_code in (0, 4), done.stderr
    return done.exit_code, lasting(json.loads(done.stdout))


def lasting(found):
    """What a command says, without what its clock says."""
    if isinstance(found, dict):
        return {key: lasting(value) for key, value in found.items() if key not in OF_THE_MOMENT}
    return [lasting(value) for value in found] if isinstance(found, list) else found


def forbid_forks(monkeypatch):
    for module in (child, apart):
        monkeypatch.setattr(module, "IS_POSSIBLE", False)

    def fork():
        pytest.fail("a process is forked")

    monkeypatch.setattr(os, "fork", fork)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_says_the_same_where_no_process_can_be_forked(command, tmp_path, monkeypatch):
    expected = result_of(command, tmp_path / "forked", monkeypatch)
    forbid_forks(monkeypatch)

    assert result_of(command, tmp_path / "alone", monkeypatch) == expected


@pytest.mark.parametrize("fault", ["", "no compiler"])
def test_models_of_a_diagnosis_are_built_without_a_fork(fault, monkeypatch):
    forbid_forks(monkeypatch)
    monkeypatch.setattr(
        candidate_models.build, "target", lambda name: SimpleNamespace(is_current=lambda: False)
    )
    monkeypatch.setattr(candidate_models, "_build", lambda name: fault)
    monkeypatch.setattr(ModelPool, "sources", lambda pool, effects: {"a": effects[0]})
    pool = ModelPool(None, None)
    built = []
    if fault:
        with pytest.raises(ConfigError, match=r"first\.fmu: no compiler"):
            pool.build([("second",), ("first",)], built.append)
    else:
        pool.build([("second",), ("first",)], built.append)

    assert built == ([] if fault else ["first", "second"])


def test_a_campaign_is_refused_and_leaves_no_folder(tmp_path, monkeypatch):
    (tmp_path / "campaign.yaml").write_text(CAMPAIGN)
    monkeypatch.chdir(tmp_path)
    forbid_forks(monkeypatch)
    done = CliRunner().invoke(main, ["sweep", "campaign.yaml", "--output", "out"])

    assert done.exit_code == 2
    assert "makes its runs in forked processes, got linux, expected Linux, or --scheduler" in done.stderr
    assert not (tmp_path / "out").exists()
