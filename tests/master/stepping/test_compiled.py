"""The compiled loop on disk: never older than its source, never damaged, and none where there is no place."""

from __future__ import annotations

import ast
import hashlib
import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from master.isolation import compiled as isolation_module
from master.stepping.machine import compiled as module
from tests.costs import long_for

PROJECT = Path(__file__).parents[3]
RUN = """
import time
from stubs import bench, clock, gain, wire
from master.stepping.machine.compiled import compiled
made = bench({"clock": clock(), "g": gain(2.0)}, [wire("clock.t", "g.u")], ["clock", "g"])
outcome = made.run(3, compiled=True)
print(outcome.status, outcome.error, outcome.result["g.y"].tolist())
"""
REPLAY = """
import numpy as np
from stubs import clock
from stubs.slave import Stub
from master.diagnosis.replay.replayer import Link, Player
block = clock()
player = Player([Link("c", block.description("c"), {}, {}, ("t",))], lambda n, d: Stub(n, d, block.law))
rows = player.play({}, np.zeros((4, 0)), (0, 3), 1.0)
print(np.isfinite(rows).all(), player.failure)
"""


def run(script, cache, project=PROJECT, **environment):
    """Output of a script in a process of its own, with a cache folder of its own."""
    path = os.pathsep.join([str(project), str(PROJECT / "tests")])
    given = os.environ | {"PYTHONPATH": path, "NUMBA_CACHE_DIR": str(cache)} | environment
    done = subprocess.run(
        [sys.executable, "-P", "-c", script],
        env={k: v for k, v in given.items() if v is not None},
        capture_output=True,
        text=True,
        cwd=cache.parent,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


GOOD = "completed None [0.0, 2.0, 4.0, 6.0]"


def files_of(cache):
    return sorted(cache.rglob("*.o"))


NOT_COMPILED = {  # used by Python code next to it
    "master.errors",
    "master.fmi.description",
    "master.fmi.native.kept_code",
    "master.installation",
}


@pytest.mark.parametrize("module", [module, isolation_module])
def test_all_files_whose_code_is_compiled_are_in_the_digest(module):
    """All that a compiled file imports of this package at its top, but where the code is kept."""
    known = {f"master.{name.replace('/', '.')}" for name in module.SOURCES}
    missing = set()
    for name in module.SOURCES:
        tree = ast.parse((module.PACKAGE / f"{name}.py").read_text(encoding="utf-8"))
        package = f"master.{name.replace('/', '.')}".rpartition(".")[0]
        for node in tree.body:
            if not isinstance(node, ast.ImportFrom) or (node.module is None and not node.level):
                continue
            base = node.module or ""
            if node.level:
                base = f"{package}.{base}".rstrip(".")
            for imported in ([base] if not base.endswith("native") else []) + [
                f"{base}.{a.name}" for a in node.names
            ]:
                file = PROJECT / f"{imported.replace('.', '/')}.py"
                if imported.startswith("master.") and file.is_file() and imported not in known | NOT_COMPILED:
                    missing.add(imported)
    assert missing == set()


@pytest.mark.slow
def test_a_changed_step_is_seen_by_a_cached_run_and_a_cached_replay(tmp_path):
    project, cache = tmp_path / "project", tmp_path / "cache"
    cache.mkdir()
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(PROJECT / "master", project / "master", ignore=ignored)
    shutil.copytree(PROJECT / "fmu_sources", project / "fmu_sources", ignore=ignored)
    assert run(RUN, cache, project) == GOOD
    assert run(REPLAY, cache, project) == "True None"
    calls = project / "master/fmi/native/calls.py"
    text = calls.read_text(encoding="utf-8")
    old = "return _indirect_call(builder, arguments[0], [_I64, _F64, _F64, _I32], [*arguments[1:], _I32(1)])"
    assert text.count(old) == 1
    calls.write_text(text.replace(old, "return _I64(3)"), encoding="utf-8")

    assert run(RUN, cache, project).startswith("failed clock at t=0 s: the step answered with status error")
    assert run(REPLAY, cache, project).startswith("False row 1: c at t=0 s: the step answered")


@pytest.mark.slow
@pytest.mark.parametrize(
    "damage", long_for(["empty", "flipped", "text"], ["empty", "cut", "flipped", "text", "unknown"])
)
def test_code_that_is_damaged_or_calls_what_is_not_here_is_made_again(damage, tmp_path_factory):
    cache = _filled_cache(tmp_path_factory)
    [file] = files_of(cache)
    good = file.read_bytes()
    middle = len(good) // 2
    flipped = bytes(b ^ 0xFF for b in good[middle : middle + 64])
    file.write_bytes(
        {
            "empty": b"",
            "cut": good[:middle],
            "flipped": good[:middle] + flipped + good[middle + 64 :],
            "text": b"not a cache",
            "unknown": calling_what_is_nowhere(good),
        }[damage]
    )

    assert run(RUN, cache) == GOOD
    changed = file.stat().st_mtime_ns
    assert file.read_bytes().split(b"\n", 3)[2:] == good.split(b"\n", 3)[2:]
    assert run(RUN, cache) == GOOD
    assert file.stat().st_mtime_ns == changed  # the second run loads what the first one made


def calling_what_is_nowhere(good):
    """A whole file whose code, by its third line, calls a function that no library has."""
    _, function, calls, code = good.split(b"\n", 3)
    rest = b"\n".join([function, calls + b" dockloop_has_no_such", code])
    return hashlib.sha256(rest).hexdigest().encode() + b"\n" + rest


def _filled_cache(factory):
    """A cache of one run, shared by the tests of this process; each mends it for the next."""
    cache = factory.getbasetemp() / "cache"
    if not cache.is_dir():
        cache.mkdir()
        assert run(RUN, cache) == GOOD
    return cache


def test_what_is_kept_is_loaded_without_numba(tmp_path_factory):
    cache = _filled_cache(tmp_path_factory)

    assert run(f"import sys{RUN}print('numba' in sys.modules)", cache) == f"{GOOD}\nFalse"


@pytest.mark.slow
def test_without_a_place_to_keep_it_the_loop_is_compiled_for_the_process(tmp_path):
    cache = tmp_path / "cache"
    cache.write_text("a file where a folder would be made")

    assert run(RUN, cache) == GOOD


def test_it_runs_with_compilation_switched_off(tmp_path):
    cache = tmp_path / "cache"
    cache.mkdir()

    assert run(RUN, cache, NUMBA_DISABLE_JIT="1") == GOOD
    assert run(REPLAY, cache, NUMBA_DISABLE_JIT="1") == "True None"
    assert files_of(cache) == []


@pytest.mark.slow
def test_a_package_that_cannot_be_written_is_cached_in_the_users_folder(tmp_path):
    project, home, here = tmp_path / "project", tmp_path / "home", tmp_path / "here"
    for folder in (home, here):
        folder.mkdir()
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(PROJECT / "master", project / "master", ignore=ignored)
    shutil.copytree(PROJECT / "fmu_sources", project / "fmu_sources", ignore=ignored)
    machine = project / "master/stepping/machine"
    machine.chmod(stat.S_IRUSR | stat.S_IXUSR)
    more = {"HOME": str(home), "XDG_CACHE_HOME": str(home / ".cache"), "NUMBA_CACHE_DIR": None}
    try:
        assert run(RUN, here, project, **more) == GOOD
        kept = files_of(home)
        assert len(kept) == 1
        assert run(RUN, here, project, **more) == GOOD
        assert files_of(home) == kept
    finally:
        machine.chmod(stat.S_IRWXU)
