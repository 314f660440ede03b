"""
Random inputs of every kind that a user writes: each ends with exit status 0, 2, 3 or 4, in time, in words.

    python -m tests.reliability.fuzz_inputs [--number 10000] [--seed 1] [--kind yaml]

Inputs are drawn from a seed (`input_kinds.py`). Each is tried in a process forked from this one. A fault is
an exception, a crash, another exit status, no message on a refusal or one that is no message (a traceback,
control characters, more than 20 kB), more than 10 s of processor time, or more than 1 GB. An input that
failed once is kept in `corpus/` and tried each time.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from click.testing import CliRunner

from master.cli import main

from .input_kinds import CORPUS, KINDS, prepare

LONGEST = 10.0
PATIENCE = 120
MOST_MEGABYTES = 1000.0
MOST_SAID = 20_000
ALLOWED = (0, 2, 3, 4)
NO_MESSAGE = re.compile(r"Traceback|<class '|object at 0x|[\x00-\x08\x0b-\x1f\x7f-\x9f\u202e]")
FAILED = 99


@dataclass
class Found:
    """Number of inputs by exit status, the slowest [s], the largest [MB], and the faults."""

    inputs: int = 0
    statuses: dict[int, int] = field(default_factory=dict)
    slowest: float = 0.0
    largest: float = 0.0
    faults: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        by = ", ".join(f"{n} with {status}" for status, n in sorted(self.statuses.items()))
        return (
            f"{self.inputs} inputs ({by}), slowest {self.slowest:.1f} s, largest {self.largest:.0f} MB, "
            f"{len(self.faults)} faults"
        )


def invoke(words: list[str]) -> tuple[int, str]:
    """Run a command in this process; return its exit status and what it said, `FAILED` and an exception."""
    done = CliRunner().invoke(main, words)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        return FAILED, "".join(traceback.format_exception(done.exception)[-4:])
    return done.exit_code, done.output


def tried(words: list[str], found: Found) -> str:
    """Run a command in a forked process; return what is wrong, empty if nothing is."""
    begin = time.monotonic()
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="surrogatepass") as said_file:
        number = os.fork()
        if number == 0:
            status = FAILED
            try:
                signal.alarm(PATIENCE)  # whose default is to end the process
                resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
                status, said = invoke(words)
                said_file.write(said)
                said_file.flush()
            finally:
                os._exit(status)
        _, ending, used = os.wait4(number, 0)
        said_file.seek(0)
        said = said_file.read()
    seconds = min(time.monotonic() - begin, used.ru_utime + used.ru_stime + 1.0)
    megabytes = used.ru_maxrss / 1024
    found.inputs += 1
    found.slowest = max(found.slowest, seconds)
    found.largest = max(found.largest, megabytes)
    if os.WIFSIGNALED(ending):
        return f"ended by {signal.Signals(os.WTERMSIG(ending)).name}"
    status = os.WEXITSTATUS(ending)
    found.statuses[status] = found.statuses.get(status, 0) + 1
    return wrong(status, said) or beyond(seconds, megabytes)


def wrong(status: int, said: str) -> str:
    """What is wrong with an exit status and what was said; empty if nothing is."""
    if status == FAILED:
        return said
    if status not in ALLOWED:
        return f"exit status {status}: {said}"
    if status != 0 and not said.strip():
        return "no message"
    if len(said) > MOST_SAID and status != 0:
        return f"{len(said)} characters: {said[:300]}"
    if bad := NO_MESSAGE.search(said):
        return f"{bad[0]!r} in {said[:600]}"
    return ""


def beyond(seconds: float, megabytes: float) -> str:
    """What is beyond its bound; empty if nothing is."""
    if seconds > LONGEST:
        return f"{seconds:.1f} s"
    return f"{megabytes:.0f} MB" if megabytes > MOST_MEGABYTES else ""


def inputs(kind: str, number: int, seed: int) -> Iterator[tuple[str, random.Random]]:
    """Names and generators of the inputs of a kind: each can be drawn alone."""
    for i in range(number):
        name = f"{kind}-{seed}-{i}"
        yield name, random.Random(name)


def main_(number: int = 10_000, seed: int = 1, kind: str | None = None, keep: Path | None = None) -> Found:
    """Try some inputs of each kind; what fails is copied to a folder, where one is named."""
    found = Found()
    kinds = [kind] if kind else list(KINDS)
    with tempfile.TemporaryDirectory(prefix="dockloop-") as place:
        folder = Path(place)
        prepare(folder)
        for text in sorted(CORPUS.glob("*.yaml")):
            shutil.copy(text, folder / "system.yaml")
            if said := tried(["check", str(folder / "system.yaml")], found):
                found.faults.append(f"{text.name}: {said}")
        for one in kinds:
            invoke(KINDS[one](folder, random.Random(one)))  # what it loads is there for the forks
            for name, draw in inputs(one, -(-number // len(kinds)), seed):
                words = KINDS[one](folder, draw)
                if said := tried(words, found):
                    found.faults.append(f"{name}: {words}: {said}")
                    if keep is not None:
                        shutil.copytree(folder, keep / name)
                        sys.stderr.write(f"{found.faults[-1]}\n")
            sys.stderr.write(f"{one}: {found}\n")
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--number", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", choices=list(KINDS))
    parser.add_argument("--keep", type=Path, metavar="DIR", help="copy the inputs that fail")
    result = main_(**vars(parser.parse_args()))
    sys.stdout.write("".join(f"{line}\n" for line in result.faults))
    sys.stdout.write(f"{result}\n")
    sys.exit(1 if result.faults else 0)
