"""A stranger follows the tutorials with the wheel."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.docs.followed import follow
from tests.installed.conftest import NOBODY, PROJECT, Stranger

pytestmark = pytest.mark.long

TUTORIALS = sorted((PROJECT / "docs" / "tutorials").glob("*.md"))


@pytest.mark.parametrize("path", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_runs_word_by_word(stranger: Stranger, path: Path) -> None:
    folder = stranger.folder / path.stem
    folder.mkdir()
    if os.geteuid() == 0:
        os.chown(folder, NOBODY, NOBODY)

    follow(
        path,
        folder,
        lambda program, *arguments: stranger.run(
            str(stranger.python.parent / program), *arguments, cwd=folder
        ),
    )
