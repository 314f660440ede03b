"""Where the system cannot fork, a command does all in its own process, and says the same."""

import json
import re

import pytest
from click.testing import CliRunner

from master.cli import main
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
    "sweep campaign.yaml --output out",
    "design-dpdc low_frequency",
    "diagnose first_case --output out",
    "replay first_case",
    "reproduce --only 17 --only ideal --output out",
    "check low_frequency",
]
OF_THE_MOMENT = {"us_per_step", "realtime_factor", "wall_s", "stepping_share"}


def result_of(command, folder, monkeypatch):
    folder.mkdir()
    (folder / "campaign.yaml").write_text(CAMPAIGN)
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


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_says_the_same_where_no_process_can_be_forked(command, tmp_path, monkeypatch):
    expected = result_of(command, tmp_path / "forked", monkeypatch)
    for module in (child, apart):
        monkeypatch.setattr(module, "IS_POSSIBLE", False)

    assert result_of(command, tmp_path / "alone", monkeypatch) == expected
