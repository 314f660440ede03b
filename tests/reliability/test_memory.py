"""Too little memory is said in words."""

from __future__ import annotations

import json

import click
import pytest
from click.testing import CliRunner

from master.cli.common import JSON, answers_errors
from master.errors import MasterError
from master.process.position import shared_memory


def test_address_space_that_the_system_does_not_give_is_named():
    with pytest.raises(MasterError, match=r"memory: the run has too little, got .* for 4398046511104 MB"):
        shared_memory(2**62)


def test_a_command_that_runs_out_of_memory_says_so_and_has_the_status_of_a_wrong_input():
    @click.command()
    @JSON
    @answers_errors
    def command(as_json):
        raise MemoryError

    done = CliRunner().invoke(command, ["--json"])

    assert done.exit_code == 2
    assert done.stderr.startswith("memory: there is too little, expected more address space")
    assert json.loads(done.stdout)["status"] == "failed"
