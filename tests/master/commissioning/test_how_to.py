"""Every block of docs/before_you_switch_on.md does what the page says."""

from __future__ import annotations

import copy
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from master.api import prepare_to_run
from master.cli import main
from master.commissioning.box import Box, own_values
from master.commissioning.chirp import Chirp
from master.commissioning.rig import run_held
from master.system.config import Config, LoadedConfig
from master.text.validation import validated
from master.text.yaml_lines import Document, read_yaml

PROJECT = Path(__file__).parents[3]
TEXT = (PROJECT / "docs" / "before_you_switch_on.md").read_text(encoding="utf-8")
PARTS = re.split(r"^```(\w*)\n", TEXT, flags=re.MULTILINE)
"""Text, kind of a fence, what follows it, ..., every second fence closing a block."""
OPENED = list(zip(PARTS[1::4], PARTS[2::4], strict=True))
COMMANDS = [line for kind, block in OPENED if kind == "sh" for line in block.splitlines()]
BLOCKS = [block for kind, block in OPENED if kind == "yaml"]
ANSWERS = [block for kind, block in OPENED if kind == ""]
E2 = PROJECT / "configs" / "experiment_1000kg.yaml"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a recording of a rig called as in the page."""
    held = run_held(prepare_to_run(E2), Chirp())
    table = np.column_stack([held.period * np.arange(len(held.s_cmd)), held.s_cmd, held.s_act, held.f_mea])
    names = "time,s_cmd,s_act,f_mea"
    np.savetxt(tmp_path / "my_rig.csv", table, delimiter=",", header=names, comments="", fmt="%.12g")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.long
def test_the_commands_run_and_end_as_the_page_says(folder):
    statuses = {}
    texts = []
    for line in COMMANDS:
        program, *words = shlex.split(line)
        assert program == "dockloop"
        answer = CliRunner().invoke(main, words)
        statuses[line] = answer.exit_code
        texts.append(answer.output)

    assert list(statuses.values()) == [0, 0, 4, 0, 5]
    assert (folder / "rig" / "parameters.ssv").is_file()
    said = "".join(texts)
    for block in ANSWERS:
        for line in block.splitlines():
            for part in line.split(" ..., "):
                assert part.strip() in said


def test_the_box_of_the_page_is_one_of_its_system():
    [box] = [block for block in BLOCKS if block.startswith("box:")]
    found = Box.model_validate(yaml.safe_load(box))

    assert found.n_plants == 9
    assert len(own_values(found, prepare_to_run(E2).system)) == 4


def test_the_guard_of_the_page_fits_into_a_system():
    [text] = [block for block in BLOCKS if block.startswith("fmus:")]
    given = yaml.safe_load(text)
    data = copy.deepcopy(read_yaml(E2).data)
    data["fmus"] |= given["fmus"]
    data["stop_when"] = given["stop_when"]
    taken = {wire["to"] for wire in given["connections"]}
    data["connections"] = [w for w in data["connections"] if w["to"] not in taken] + given["connections"]
    order = data["coupling"]["order"]
    order.insert(order.index("compensator") + 1, "guard")
    document = Document(E2, data)

    experiment = prepare_to_run(LoadedConfig(validated(Config, document, "system"), document))

    assert [str(stop) for stop in experiment.scenario.stops] == ["guard.alarm > 0"]
    ages = {entry.target: entry.mean for entry in experiment.ledger.entries}
    plain = {entry.target: entry.mean for entry in prepare_to_run(E2).ledger.entries}
    assert ages["guard.f_comp"] == ages["spacecraft.f"] == plain["spacecraft.f"]
    assert ages["guard.s_cmd"] == ages["motion_simulator.s_cmd"] == plain["motion_simulator.s_cmd"]
