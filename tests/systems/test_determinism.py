"""The same system gives the same bits, whatever surrounds the run."""

import hashlib
import locale
import os
import subprocess
import sys

import pytest
from click.testing import CliRunner

from master.cli import main
from master.isolation.options import IS_POSSIBLE
from tests.conftest import PROJECT

COMMAND = ("run", "configs/low_frequency.yaml", "--stop-time", "0.2")
OTHER = {
    "PYTHONHASHSEED": "4711",
    "TZ": "Pacific/Chatham",
    "LC_ALL": "tr_TR.UTF-8",
    "LANG": "de_DE.UTF-8",
    "OMP_NUM_THREADS": "3",
    "NUMBA_NUM_THREADS": "1",
    "COLUMNS": "20",
}
PLAIN = {
    "PYTHONHASHSEED": "0",
    "TZ": "UTC",
    "LC_ALL": "C",
    "OMP_NUM_THREADS": "1",
}


def digest(folder):
    return hashlib.sha256((folder / "result.csv").read_bytes()).hexdigest()


def run_here(folder, *options):
    done = CliRunner().invoke(main, [*COMMAND, "--output", str(folder), *options])
    assert done.exit_code == 0, done.output
    return digest(folder)


def run_apart(folder, surroundings):
    subprocess.run(
        [sys.executable, "-m", "master", *COMMAND, "--output", str(folder)],
        cwd=PROJECT,
        env={**os.environ, **surroundings},
        check=True,
        capture_output=True,
    )
    return digest(folder)


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    before = os.getcwd()
    os.chdir(PROJECT)
    yield run_here(tmp_path_factory.mktemp("plain"))
    os.chdir(before)


@pytest.mark.long
def test_rows_that_are_written_while_the_run_goes_on_are_the_same(plain, tmp_path, monkeypatch):
    monkeypatch.setattr("master.runs.execute.ROWS_IN_MEMORY", 50)

    assert run_here(tmp_path) == plain


@pytest.mark.skipif(not IS_POSSIBLE, reason="Linux on x86_64 or aarch64")
def test_fmus_in_processes_of_their_own_give_the_same(plain, tmp_path):
    assert run_here(tmp_path / "all", "--isolate", "all") == plain
    assert run_here(tmp_path / "two", "--isolate", "spacecraft,compensator") == plain


@pytest.mark.long
def test_the_locale_of_the_process_changes_nothing(plain, tmp_path):
    before = locale.setlocale(locale.LC_ALL)
    known = [name for name in ("de_DE.UTF-8", "fr_FR.UTF-8", "tr_TR.UTF-8", "C.UTF-8") if _is_known(name)]
    try:
        for name in known[:2]:
            locale.setlocale(locale.LC_ALL, name)
            assert run_here(tmp_path / name) == plain
    finally:
        locale.setlocale(locale.LC_ALL, before)


def _is_known(name):
    before = locale.setlocale(locale.LC_ALL)
    try:
        locale.setlocale(locale.LC_ALL, name)
    except locale.Error:
        return False
    locale.setlocale(locale.LC_ALL, before)
    return True


@pytest.mark.long
@pytest.mark.parametrize("surroundings", [PLAIN, OTHER], ids=["plain", "other"])
def test_hash_seed_time_zone_locale_threads_and_terminal_change_no_byte(plain, tmp_path, surroundings):
    assert run_apart(tmp_path, surroundings) == plain


@pytest.mark.long
def test_the_loop_that_is_not_compiled_gives_the_same(plain, tmp_path):
    assert run_apart(tmp_path, {"NUMBA_DISABLE_JIT": "1"}) == plain
