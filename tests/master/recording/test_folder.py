import os
import subprocess
import sys

import pytest

from master.errors import DataError
from master.recording.folder import OutputFolder
from master.recording.names import folder_name, results_folder

OLD = ["summary.json", "result.csv", "result.parquet", "result.part-00001.parquet", "fmu.log"]


def test_what_an_older_run_left_is_gone_before_a_run_and_other_files_stay(tmp_path):
    for name in [*OLD, "plots.png", "notes.txt"]:
        (tmp_path / name).write_text("old")
    with OutputFolder(tmp_path):
        left = {path.name for path in tmp_path.iterdir()}

    assert left == {"notes.txt", ".dockloop.lock"}
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_a_second_run_into_one_folder_is_refused_by_the_number_of_the_first(tmp_path):
    with OutputFolder(tmp_path), pytest.raises(DataError) as caught:
        OutputFolder(tmp_path)

    assert f"another run writes here, got process {os.getpid()}" in str(caught.value)


def test_a_second_run_leaves_the_files_of_the_first_alone(tmp_path):
    with OutputFolder(tmp_path):
        (tmp_path / "result.csv").write_text("rows")
        with pytest.raises(DataError):
            OutputFolder(tmp_path)

        assert (tmp_path / "result.csv").read_text() == "rows"


def test_the_lock_of_a_process_that_was_killed_is_taken(tmp_path):
    code = (
        "import os, signal; from pathlib import Path; from master.recording.folder import OutputFolder\n"
        f"folder = OutputFolder(Path({str(tmp_path)!r})); os.kill(os.getpid(), signal.SIGKILL)"
    )
    killed = subprocess.run([sys.executable, "-c", code], check=False)
    assert killed.returncode == -9
    assert (tmp_path / ".dockloop.lock").exists()

    with OutputFolder(tmp_path) as folder:
        assert not folder.vanished()


@pytest.mark.parametrize("place", ["file", "file/below", "a\0b"])
def test_a_folder_that_cannot_be_made_is_refused_with_its_name(tmp_path, place):
    (tmp_path / "file").write_text("")

    with pytest.raises(DataError, match="cannot be written"):
        OutputFolder(tmp_path / place)


def test_a_folder_that_is_removed_or_replaced_has_vanished(tmp_path):
    path = tmp_path / "out"
    with OutputFolder(path) as folder:
        path.rename(tmp_path / "moved")
        assert folder.vanished()
        path.mkdir()
        assert folder.vanished()
        folder.secure()
        assert not folder.vanished()


NAMES = [
    "../../outside",
    "/absolute",
    "..",
    ".",
    "",
    "a/b",
    "a\\b",
    "con",
    "NUL.txt",
    "a" * 300,
    "line\nbreak",
    "zero\0",
    "\ud800",
    "ends.",
    "~",
    "größe",
    "-option",
    ".hidden",
]


@pytest.mark.parametrize("text", NAMES)
def test_no_name_leads_out_of_its_folder(text, tmp_path):
    name = folder_name(text)
    (tmp_path / name).mkdir()

    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert name.isascii()
    assert not name.startswith((".", "-"))
    assert len(name) <= 80


def test_different_names_never_share_a_folder():
    texts = [*NAMES, "a_b", "a b", "a:b", "a?b", "A", "outside"]

    assert len({folder_name(text) for text in texts}) == len(texts)


def test_a_plain_name_is_the_folder_itself():
    assert results_folder("low_frequency", None, []).as_posix() == "results/low_frequency/default"
    assert results_folder("low_frequency", "none", []).as_posix() == "results/low_frequency/none"


def test_variants_and_assignments_have_folders_of_their_own():
    runs = [
        (None, []),
        ("default", []),
        ("none", []),
        (None, ["a.k=1"]),
        (None, ["a.k=2"]),
        ("none", ["a.k=1"]),
        (None, ["none"]),
        (None, ["a.k=1", "b.k=1"]),
        (None, ["a.k=1,b.k=1 "]),
    ]

    assert len({results_folder("x", variant, set_) for variant, set_ in runs}) == len(runs)


def test_the_last_assignment_of_a_variable_names_the_folder_in_any_order():
    first = results_folder("x", None, ["a.k=1", "b.k=3", "a.k=2"])

    assert first == results_folder("x", None, ["b.k=3", "a.k=2"])
    assert first.name == "default,a.k=2,b.k=3"
