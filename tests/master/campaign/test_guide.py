"""Every block of docs/campaigns.md runs as it is, in their order."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from master.cli import main

PROJECT = Path(__file__).parents[3]
TEXT = (PROJECT / "docs" / "campaigns.md").read_text(encoding="utf-8")


@pytest.mark.long
def test_every_block_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```(yaml|sh|python)\n(.*?)```", TEXT, re.DOTALL)
    assert {kind for kind, _ in blocks} == {"yaml", "sh", "python"}
    for kind, block in blocks:
        if kind == "yaml":
            name = block.partition("\n")[0].removeprefix("# ")
            (tmp_path / name).write_text(block, encoding="utf-8")
        elif kind == "python":
            exec(compile(block, "docs/campaigns.md", "exec"), {"__name__": "guide"})
        else:
            for line in block.splitlines():
                done = CliRunner().invoke(main, line.split()[1:])
                assert done.exit_code == 0, f"{line}: {done.output}"
