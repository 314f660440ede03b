"""A page of the documents followed word by word: its blocks run one after the other in one folder."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

_BLOCK = re.compile(r"^```(sh|python)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_FILE = re.compile(r"# (\w+\.py)\n")


class Block(NamedTuple):
    """Language and text."""

    language: str
    text: str


def blocks(path: Path) -> list[Block]:
    """Blocks of commands and programs of a page, in their order."""
    return [Block(*found) for found in _BLOCK.findall(path.read_text(encoding="utf-8"))]


def follow(path: Path, folder: Path) -> None:
    """Run every block; a program whose first line is a comment with the name of a file is saved as that."""
    for block in blocks(path):
        named = _FILE.match(block.text)
        if named is not None:
            (folder / named[1]).write_text(block.text, encoding="utf-8")
        elif block.language == "python":
            _run([sys.executable, "-c", block.text], folder)
        else:
            for line in filter(None, block.text.splitlines()):
                program, *words = line.split()
                assert program == "dockloop", line
                _run([sys.executable, "-m", "master", *words], folder)


def _run(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command[2:]}: {done.stdout}{done.stderr}"
