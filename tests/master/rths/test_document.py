"""The commands of docs/rths.md run as they are; its tables name every method, league and case."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

from master.cli import main
from master.rths.benchmark import CASES, CONFIGURATIONS, METHODS
from master.rths.measures import N_MEASURES

TEXT = (Path(__file__).parents[3] / "docs" / "rths.md").read_text(encoding="utf-8")
COMMANDS = "\n".join(re.findall(r"```console\n(.*?)\n```", TEXT, re.DOTALL)).splitlines()


def rows(heading):
    section = TEXT.partition(f"## {heading}")[2].partition("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith("|")][2:]
    return [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in lines]


def test_the_table_has_each_method_and_league_under_each_record_in_each_case():
    found = [(row[0], int(row[1]), row[3], row[4]) for row in rows("All methods")]
    records = {row[0] for row in found}
    expected = {(r, c, *key) for r in records for c in CASES for key in CONFIGURATIONS}

    assert len(records) == 3
    assert sorted(found) == sorted(expected)
    assert {len(row) for row in rows("All methods")} == {5 + N_MEASURES}


def test_the_page_names_every_method_as_an_option():
    option = next(line for line in TEXT.splitlines() if line.startswith("| `--method`"))

    assert set(re.findall(r"`(\w+)`", option)) == set(METHODS)


@pytest.mark.long
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_of_the_page_runs(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(main, shlex.split(command)[1:])

    assert done.exit_code == 0, done.output
