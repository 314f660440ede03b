"""The command and the cells of docs/compensators.md run as they are; its table names every method."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

from master.cli import main
from master.comparison.cells import read_cells
from master.comparison.compare import tasks
from master.comparison.methods import all_methods, chosen
from master.installation import CONFIG_FOLDER

TEXT = (Path(__file__).parents[3] / "docs" / "compensators.md").read_text(encoding="utf-8")
[COMMAND] = re.findall(r"```console\n(.*?)\n```", TEXT, re.DOTALL)
[CELLS] = re.findall(r"```yaml\n(.*?)```", TEXT, re.DOTALL)


def test_every_method_is_in_the_table_of_what_it_is_told():
    table = TEXT.partition("## What each method is told")[2].partition("## ")[0]
    names = {
        name
        for row in re.findall(r"^\| (`.*?) \|", table, re.MULTILINE)
        for name in re.findall(r"`(\w+)`", row)
    }

    assert names == set(all_methods())


def test_the_cells_of_the_page_are_right(tmp_path):
    path = tmp_path / "cells.yaml"
    path.write_text(CELLS, encoding="utf-8")

    assert len(tasks([CONFIG_FOLDER / "experiment_1000kg.yaml"], read_cells(path), chosen("robust"), 1)) == 6


@pytest.mark.slow
def test_the_command_of_the_page_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cells.yaml").write_text(CELLS, encoding="utf-8")
    done = CliRunner().invoke(main, shlex.split(COMMAND)[1:])

    assert done.exit_code == 0, done.output
    assert "slow sensor" in done.stdout
