"""
A fault at each write, rename and fsync of a run's files in turn: nothing is left that does not open.

    python -m tests.reliability.faults_in_files

A small C library that is preloaded lets the n-th call fail with ENOSPC, EIO or EDQUOT (once, or for good as a
full disk does) or ends the process amid it. What is left then is opened; where there is a checkpoint, the
files go on from it and have the bytes of files that nothing disturbed.
"""

from __future__ import annotations

import ctypes
import errno
import json
import os
import shutil
import subprocess
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import parquet

from master.errors import DataError
from master.recording.checkpoints import CheckpointFiles, Mark, read_checkpoint
from master.recording.files import ResultFiles, write_result
from master.recording.folder import OutputFolder
from master.recording.recorder import Result
from master.recording.whole_file import write_whole

HERE = Path(__file__).parent
N = 600
STEP = 100
VALUES = np.random.default_rng(9).normal(size=(N, 3))
KINDS = {
    "killed": (0, 0),
    "no space once": (errno.ENOSPC, 0),
    "no space from then on": (errno.ENOSPC, 1),
    "input/output error once": (errno.EIO, 0),
    "quota used up": (errno.EDQUOT, 1),
}
_OK, _SAID = 0, 3


@dataclass
class Found:
    """Number of faults put in, and what was wrong afterwards, a line each."""

    faults: int = 0
    problems: list[str] = field(default_factory=list)


def rows(begin: int, end: int) -> Result:
    """Some rows of a run."""
    return Result(np.arange(begin, end) * 0.5, ("a.x", "a.y", "b.z"), ("m", "1", "N"), VALUES[begin:end])


def stream(folder: Path, files: ResultFiles, begin: int) -> None:
    """Write rows in blocks, with a checkpoint after every second one, and what a run leaves in the end."""
    checkpoints = CheckpointFiles(folder, begin)
    try:
        for k in range(begin, N, STEP):
            files.write(rows(k, k + STEP))
            if k // STEP % 2:
                mark = Mark(k + STEP, k + STEP, files.mark())
                checkpoints.save(mark, VALUES[: k + STEP], f"state {k}".encode())
        files.close()
        write_whole(folder / "summary.json", json.dumps({"rows": N}))
    except OSError:
        with suppress(OSError):
            files.rescue()
        os._exit(_SAID)


def streamed(folder: Path) -> None:
    """What a run with checkpoints does."""
    stream(folder, ResultFiles(folder), 0)


def at_once(folder: Path) -> None:
    """What a run in memory does."""
    try:
        write_result(rows(0, N), folder)
        write_whole(folder / "summary.json", json.dumps({"rows": N}))
    except OSError:
        os._exit(_SAID)


def forked(work, folder: Path, library, fault: tuple[int, int, int] | None) -> int:
    """Do some work in a forked process under a fault (after, errno, for good); return its wait status."""
    process = os.fork()
    if process == 0:
        after, number, for_good = fault or (-1, 0, 0)
        library.fault_arm(str(folder).encode(), ctypes.c_long(after), number, for_good)
        status = 1
        try:
            work(folder)
            status = _OK
        finally:
            if fault is None:
                (folder.parent / "calls").write_text(str(library.fault_calls()))
            os._exit(status)
    _, status = os.waitpid(process, 0)
    return status


def problems_in(folder: Path, *, is_whole: bool) -> list[str]:
    """Open all that is left; every row has to be a row of the run, in order."""
    found = []
    n_rows = 0
    for path in [*sorted(folder.glob("result.part-*.parquet")), *folder.glob("result.parquet")]:
        first = n_rows if "part" in path.name else 0
        try:
            table = parquet.read_table(path)
        except (OSError, pa.ArrowException) as error:
            found.append(f"{path.name} does not open: {error}")
            continue
        values = np.column_stack([table[name].to_numpy() for name in table.column_names[1:]])
        if not np.array_equal(values, VALUES[first : first + len(values)]):
            found.append(f"{path.name} has other rows")
        n_rows = first + len(values)
    csv = folder / "result.csv"
    if csv.exists():
        lines = csv.read_bytes().split(b"\n")[1:-1]
        values = np.array([[float(x) for x in line.split(b",")[1:]] for line in lines]).reshape(-1, 3)
        if not np.array_equal(values, VALUES[: len(values)]):
            found.append("result.csv has other rows")
    if (folder / "summary.json").exists() and json.loads((folder / "summary.json").read_text())["rows"] != N:
        found.append("summary.json is another one")
    if is_whole and not (csv.exists() and (folder / "result.parquet").exists()):
        found.append("files are missing though nothing failed")
    return found


def problems_of_going_on(folder: Path, expected: Path) -> list[str]:
    """Go on from the checkpoint that is left; the files have to be those of an undisturbed run."""
    try:
        last = read_checkpoint(folder)
    except DataError as error:
        return [f"checkpoint: {error}"]
    if last is None or (folder / "summary.json").exists():
        return []
    if not np.array_equal(last.kept, VALUES[: last.mark.n_kept]):
        return ["checkpoint: other rows"]
    with OutputFolder(folder, goes_on=True):
        try:
            stream(folder, ResultFiles(folder, mark=last.mark.files), last.mark.n_rows)
        except DataError as error:
            return [f"does not go on: {error}"]
    same = [
        (folder / n).read_bytes() == (expected / n).read_bytes() for n in ("result.csv", "result.parquet")
    ]
    return [] if all(same) else ["goes on with other bytes"]


def sweep(every: int = 1) -> Found:
    """Put a fault of each kind at every n-th call."""
    library = ctypes.CDLL(os.environ["LD_PRELOAD"])
    found = Found()
    with tempfile.TemporaryDirectory(prefix="dockloop-") as place:
        for work in (streamed, at_once):
            expected = Path(place) / work.__name__
            assert forked(work, expected, library, None) == _OK
            n_calls = int((expected.parent / "calls").read_text())
            for kind, (number, for_good) in KINDS.items():
                for after in range(0, n_calls, every):
                    folder = Path(place) / "out"
                    shutil.rmtree(folder, ignore_errors=True)
                    status = forked(work, folder, library, (after, number, for_good))
                    whole = os.WIFEXITED(status) and os.WEXITSTATUS(status) == _OK
                    said = problems_in(folder, is_whole=whole)
                    if os.WIFEXITED(status) and os.WEXITSTATUS(status) not in (_OK, _SAID):
                        said.append(f"ended with status {os.WEXITSTATUS(status)}")
                    said += problems_of_going_on(folder, expected)
                    found.faults += 1
                    found.problems += [f"{work.__name__}, {kind} at call {after}: {one}" for one in said]
    return found


def preloaded(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run this file with the library before all others."""
    library = folder / "faulty.so"
    source = HERE / "faulty.c"
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", library, source, "-ldl"], check=True)
    environment = os.environ | {"LD_PRELOAD": str(library), "PYTHONPATH": str(HERE.parents[1])}
    command = [sys.executable, "-m", "tests.reliability.faults_in_files", *words]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


if __name__ == "__main__":
    if "faulty.so" not in os.environ.get("LD_PRELOAD", ""):
        with tempfile.TemporaryDirectory(prefix="dockloop-") as place:
            done = preloaded(Path(place), *sys.argv[1:])
        sys.stdout.write(done.stdout)
        sys.stderr.write(done.stderr)
        sys.exit(done.returncode)
    result = sweep(int(sys.argv[1]) if sys.argv[1:] else 1)
    sys.stdout.write("".join(f"{line}\n" for line in result.problems))
    sys.stdout.write(f"{result.faults} faults, {len(result.problems)} problems\n")
    sys.exit(1 if result.problems else 0)
