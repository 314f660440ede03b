"""
A run killed at random moments, looked at, and resumed until it ends.

    python -m tests.reliability.kill_and_resume [--number 200] [--seed 1] [--stop-time 10] [--kinds KIND ...]

Runs with checkpoints (which stream), the same with every FMU isolated, and runs in memory, which are begun
again, take turns until each kind has been killed that many times. Each sample begins a run, sends SIGKILL to
it (or, in a fifth of the samples, to its stepping child alone) at a random moment, looks whether a process is
left, opens every file that is left, and resumes; the resumed run is killed again with probability 0.3. In the
end each must have the bits of a run that nobody disturbed. Runs are forked from this process, which has
loaded what they need and stepped once, and draw nothing: more of their time is stepping and writing.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import pyarrow as pa
from pyarrow import parquet

from master.api import prepare_to_run
from master.cli import main as command
from master.cli import run as _run  # noqa: F401 - loaded before the forks
from master.evaluation.report import load_libraries
from master.experiment.prepare import Request
from master.stepping.opened import OpenRun
from master.stepping.outcome import RunOptions

CONFIGS = Path(__file__).parents[2] / "configs"
CHECKPOINT = ("--checkpoint", "0.05s")
KINDS = {
    "streamed": CHECKPOINT,
    "isolated": (*CHECKPOINT, "--isolate", "all"),
    "in memory": (),
}
_AGAIN = 0.3
_CHILD_ALONE = 0.2
_MOST_KILLS = 20


@dataclass
class Found:
    """What the samples came to; `unreadable`, `left` and `different` are faults, a line each."""

    samples: int = 0
    kills: Counter[str] = field(default_factory=Counter)
    """By the kind of run."""
    resumed: int = 0
    begun_again: int = 0
    unreadable: list[str] = field(default_factory=list)
    left: list[str] = field(default_factory=list)
    different: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        kills = ", ".join(f"{number} {kind}" for kind, number in self.kills.items())
        return (
            f"{self.samples} samples, {self.kills.total()} kills ({kills}), {self.resumed} resumed, "
            f"{self.begun_again} begun again, {len(self.unreadable)} unreadable files, "
            f"{len(self.left)} left processes, {len(self.different)} with other bits"
        )

    def is_clean(self) -> bool:
        """Whether nothing was wrong."""
        return not (self.unreadable or self.left or self.different)


class Command:
    """A command in a forked process, which leads a group of processes of its own."""

    def __init__(self, *words: object, says: Path = Path(os.devnull)) -> None:
        self.number = os.fork()
        if self.number == 0:
            status = 1
            try:
                os.setpgid(0, 0)
                output = os.open(says, os.O_RDWR | os.O_CREAT | os.O_TRUNC)
                for handle in range(3):
                    os.dup2(output, handle)
                command(list(map(str, words)))
            except SystemExit as end:
                status = end.code if isinstance(end.code, int) else 1
            finally:
                os._exit(status)
        with suppress(OSError):  # it may have done so itself, or ended
            os.setpgid(self.number, self.number)
        self.status: int | None = None

    def has_ended(self) -> bool:
        """Whether it has ended."""
        if self.status is None:
            number, status = os.waitpid(self.number, os.WNOHANG)
            self.status = status if number else None
        return self.status is not None

    def wait(self, seconds: float) -> int:
        """Wait for its end; return what the kernel says of it."""
        until = time.monotonic() + seconds
        while not self.has_ended():
            if time.monotonic() > until:
                os.killpg(self.number, signal.SIGKILL)
                raise TimeoutError(f"no end after {seconds:g} s")
            time.sleep(0.02)
        assert self.status is not None
        return self.status

    def kill(self, *, child_alone: bool) -> None:
        """Send SIGKILL to the process, or to its child where it has one."""
        children = Path(f"/proc/{self.number}/task/{self.number}/children")
        numbers = children.read_text().split() if child_alone else []
        os.kill(int(numbers[0]) if numbers else self.number, signal.SIGKILL)
        self.wait(120.0)

    def leaves_processes(self) -> bool:
        """Whether something that it began is there long after its end."""
        until = time.monotonic() + 20.0
        while time.monotonic() < until:
            try:
                os.killpg(self.number, 0)
            except ProcessLookupError:
                return False
            time.sleep(0.02)
        return True


def unreadable(folder: Path) -> list[str]:
    """Open every file that a tool may look at; return what does not open."""
    faults = []
    for path in folder.glob("result*.parquet"):
        try:
            parquet.read_table(path, use_threads=False)
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


def undrawn(place: Path) -> Path:
    """Write a system whose runs make no picture, which would take most of their time."""
    file = place / "low_frequency.yaml"
    file.write_text((CONFIGS / file.name).read_text(encoding="utf-8") + "plots: []\n", encoding="utf-8")
    return file


def load_all(system: Path) -> None:
    """Load what a run needs, its compiled stepping loop too, so that a forked run begins to step at once."""
    load_libraries()
    experiment = prepare_to_run(system, Request(stop_time=0.1))
    run = OpenRun(experiment.system, experiment.schedule, experiment.grid, RunOptions())
    run.step(1)
    run.close()


def sample(
    folder: Path, kind: str, system: list[object], lasts: float, random_: random.Random, found: Found
) -> None:
    """Begin a run of some kind, kill it, look and resume until it ends."""
    run = [*system, *KINDS[kind]]
    process = Command(*run, "--output", folder)
    for _ in range(_MOST_KILLS):
        time.sleep(random_.uniform(0.0, lasts))
        if process.has_ended():
            break
        process.kill(child_alone=random_.random() < _CHILD_ALONE)
        found.kills[kind] += 1
        if process.leaves_processes():
            found.left.append(folder.name)
        found.unreadable += [f"{folder.name}: {fault}" for fault in unreadable(folder)]
        manifest = folder / "manifest.json"
        if manifest.exists() and json.loads(manifest.read_text())["status"] == "completed":
            break
        if manifest.exists() and CHECKPOINT[0] in run:
            found.resumed += 1
            process = Command("resume", folder)
        else:
            found.begun_again += 1
            process = Command(*run, "--output", folder)
        if random_.random() > _AGAIN:
            break
    process.wait(600.0)


def main(
    number: int = 200, seed: int = 1, stop_time: float = 10.0, kinds: Sequence[str] = tuple(KINDS)
) -> Found:
    """Kill each of some kinds of runs some times; progress goes to standard error."""
    random_ = random.Random(seed)
    found = Found()
    with tempfile.TemporaryDirectory(prefix="dockloop-") as place:
        system = undrawn(Path(place))
        load_all(system)
        run: list[object] = ["run", system, "--stop-time", stop_time]
        expected = Path(place) / "expected"
        lasts = {}
        for kind in kinds:
            begin = time.monotonic()
            said = Path(place) / "said"
            undisturbed = Command(*run, *KINDS[kind], "--output", expected, says=said)
            assert undisturbed.wait(600.0) == 0, f"{kind}: {said.read_text()[-2000:]}"
            lasts[kind] = time.monotonic() - begin
        while left := [kind for kind in kinds if found.kills[kind] < number]:
            kind = left[found.samples % len(left)]
            folder = Path(place) / f"sample-{found.samples}-{kind.replace(' ', '-')}"
            sample(folder, kind, run, lasts[kind], random_, found)
            found.samples += 1
            if not (folder / "result.parquet").exists() or bits(folder) != bits(expected):
                found.different.append(folder.name)
            shutil.rmtree(folder, ignore_errors=True)
            sys.stderr.write(f"{found}\n")
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--number", type=int, default=200, help="kills of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--stop-time", type=float, default=10.0)
    parser.add_argument("--kinds", nargs="+", choices=list(KINDS), default=list(KINDS))
    result = main(**vars(parser.parse_args()))
    for fault in (*result.unreadable, *result.left, *result.different):
        sys.stdout.write(f"{fault}\n")
    sys.stdout.write(f"{result}\n")
    sys.exit(0 if result.is_clean() else 1)
