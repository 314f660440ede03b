"""
A run with checkpoints killed at random moments, looked at, and resumed until it ends.

    python -m tests.reliability.kill_and_resume [--number 200] [--seed 1] [--stop-time 60]

Each sample begins a run, sends SIGKILL to it (or, in a fifth of the samples, to its stepping child alone) at
a random moment, opens every file that is left, and resumes; the resumed run is killed again with probability
0.3. In the end each must have the bits of a run that nobody disturbed.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import pyarrow as pa
from pyarrow import parquet

PROJECT = Path(__file__).parents[2]
CHECKPOINT = "0.05s"
_AGAIN = 0.3
_CHILD_ALONE = 0.2
_MOST_KILLS = 20


@dataclass
class Found:
    """What the samples came to; `unreadable` and `different` are faults, a line each."""

    samples: int = 0
    kills: int = 0
    resumed: int = 0
    begun_again: int = 0
    unreadable: list[str] = field(default_factory=list)
    different: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        return (
            f"{self.samples} samples, {self.kills} kills, {self.resumed} resumed, {self.begun_again} killed "
            f"before there was a manifest, {len(self.unreadable)} unreadable files, "
            f"{len(self.different)} with other bits"
        )


def dockloop(*words: object) -> subprocess.Popen[bytes]:
    """Begin the command."""
    environment = os.environ | {"PYTHONPATH": str(PROJECT)}
    quiet = subprocess.DEVNULL
    command = [sys.executable, "-m", "master", *map(str, words)]
    return subprocess.Popen(command, env=environment, stdout=quiet, stderr=quiet, cwd=PROJECT)


def kill(process: subprocess.Popen[bytes], *, child_alone: bool) -> None:
    """Send SIGKILL to the process, or to its child where it has one."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    numbers = children.read_text().split() if child_alone and process.poll() is None else []
    if numbers:
        os.kill(int(numbers[0]), signal.SIGKILL)
    else:
        process.kill()
    process.wait(timeout=120.0)


def unreadable(folder: Path) -> list[str]:
    """Open every file that a tool may look at; return what does not open."""
    faults = []
    for path in folder.glob("result*.parquet"):
        try:
            parquet.read_table(path)
        except (OSError, pa.ArrowException) as error:
            faults.append(f"{path.name}: {error}")
    for path in folder.glob("*.json"):
        try:
            json.loads(path.read_text(encoding="utf-8"))
        except ValueError as error:
            faults.append(f"{path.name}: {error}")
    csv = folder / "result.csv"
    if csv.exists():
        lines = csv.read_bytes().split(b"\n")[:-1]  # a last line without its end is no row
        widths = {line.count(b",") for line in lines}
        if len(widths) > 1:
            faults.append(f"{csv.name}: rows of different lengths")
    return faults


def bits(folder: Path) -> bytes:
    """Return all that the rows hold."""
    return (folder / "result.csv").read_bytes() + (folder / "result.parquet").read_bytes()


def sample(folder: Path, run: list[object], lasts: float, random_: random.Random, found: Found) -> None:
    """Begin, kill, look and resume until the run ends."""
    process = dockloop(*run, "--output", folder)
    for _ in range(_MOST_KILLS):
        time.sleep(random_.uniform(0.0, lasts))
        if process.poll() is not None:
            return
        kill(process, child_alone=random_.random() < _CHILD_ALONE)
        found.kills += 1
        found.unreadable += [f"{folder.name}: {fault}" for fault in unreadable(folder)]
        if not (folder / "manifest.json").exists():
            found.begun_again += 1
            process = dockloop(*run, "--output", folder)
        elif json.loads((folder / "manifest.json").read_text())["status"] == "completed":
            return
        else:
            found.resumed += 1
            process = dockloop("resume", folder)
        if random_.random() > _AGAIN:
            break
    process.wait(timeout=300.0)


def main(number: int = 200, seed: int = 1, stop_time: float = 60.0) -> Found:
    """Take some samples; progress goes to standard error."""
    random_ = random.Random(seed)
    found = Found()
    run: list[object] = ["run", "low_frequency", "--stop-time", stop_time]
    with tempfile.TemporaryDirectory(prefix="dockloop-") as place:
        expected = Path(place) / "expected"
        begin = time.monotonic()
        assert dockloop(*run, "--output", expected).wait() == 0
        lasts = time.monotonic() - begin
        for i in range(number):
            folder = Path(place) / f"sample-{i}"
            sample(folder, [*run, "--checkpoint", CHECKPOINT], lasts, random_, found)
            found.samples += 1
            if not (folder / "result.parquet").exists() or bits(folder) != bits(expected):
                found.different.append(folder.name)
            else:
                for path in folder.iterdir():
                    path.unlink()
            sys.stderr.write(f"\r{found}")
    sys.stderr.write("\n")
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--number", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--stop-time", type=float, default=60.0)
    result = main(**vars(parser.parse_args()))
    sys.stdout.write(f"{result}\n")
    sys.exit(1 if result.unreadable or result.different else 0)
