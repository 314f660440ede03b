"""Every command of docs/runs.md runs as it is, in their order; its YAML is a part of a system."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner

from master.cli import main
from master.experiment.prepare import prepare

PROJECT = Path(__file__).parents[3]
TEXT = (PROJECT / "docs" / "runs.md").read_text(encoding="utf-8")
COMMANDS = [
    line for block in re.findall(r"```sh\n(.*?)```", TEXT, re.DOTALL) for line in block.splitlines() if line
]


@pytest.mark.long
def test_every_command_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert len(COMMANDS) == 11
    for line in COMMANDS:
        program, *words = line.split()
        done = CliRunner().invoke(main, words)

        assert program == "dockloop"
        assert done.exit_code == 0, f"{line}: {done.output}"


def test_the_yaml_is_a_part_of_a_system(tmp_path):
    [part] = re.findall(r"```yaml\n(.*?)```", TEXT, re.DOTALL)
    system = yaml.safe_load((PROJECT / "configs" / "low_frequency.yaml").read_text(encoding="utf-8"))
    path = tmp_path / "system.yaml"
    path.write_text(yaml.safe_dump(system | yaml.safe_load(part)), encoding="utf-8")
    experiment = prepare(path)

    assert experiment.selection.every == 10
    assert experiment.plots[0] == ("contact.f_act", "force_sensor.f_mea")
