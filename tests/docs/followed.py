"""A page of the documents followed word by word: its blocks run one after the other in one folder."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
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


Run = Callable[..., "subprocess.CompletedProcess[str]"]


def follow(path: Path, folder: Path, run: Run | None = None) -> None:
    """
    Run every block; a program whose first line is a comment with the name of a file is saved as that.

    `run` runs a program, "python" or "dockloop", and its arguments in the folder: by default those of this
    environment.
    """
    for block in blocks(path):
        named = _FILE.match(block.text)
        if named is not None:
            (folder / named[1]).write_text(block.text, encoding="utf-8")
            continue
        lines = filter(None, block.text.splitlines())
        commands = [["python", "-c", block.text]] if block.language == "python" else map(str.split, lines)
        for program, *arguments in commands:
            assert program in ("python", "dockloop"), program
            done = run(program, *arguments) if run else _run_here(folder, program, *arguments)
            assert done.returncode == 0, f"{arguments}: {done.stdout}{done.stderr}"


def _run_here(folder: Path, program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, *([] if program == "python" else ["-m", "master"]), *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
