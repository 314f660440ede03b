"""
Long runs, large systems and many systems: memory stays flat, files are bounded, no handle or folder is left.

    python -m tests.reliability.soak ticks    [--number 100000000]   one run; memory after 1e6 and all ticks
    python -m tests.reliability.soak messages [--number 10000000]    with another message each step
    python -m tests.reliability.soak wide     [--number 100000]      200 FMUs, 5000 wires, 20 000 variables
    python -m tests.reliability.soak systems  [--number 10000]       one after the other in this process
    python -m tests.reliability.soak apart    [--number 1000]        the same, each run in its own process

Memory is what this process and those that it began have allocated, shared pages by their share.
"""

from __future__ import annotations

import argparse
import gc
import os
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import dockloop
from master.api import prepare_to_run
from master.experiment.prepare import Request
from master.runs.execute import run_into
from master.runs.manifest import Described
from tests.foreign import faulty
from tests.foreign.build import compile_c, write_fmu
from tests.foreign.faulty import Deed, When

HERE = Path(__file__).parent
MEGABYTE = 2**20
PORTS = 25
LOCALS = 50
FMUS = 200
FIRST_TICKS = 1_000_000
MOST_ROWS = 1000
MOST_BYTES = 60 * MEGABYTE
BOUND = 1.02


@dataclass(frozen=True)
class Held:
    """What this process and those that it began have."""

    memory: float
    """[MB]"""
    files: int
    threads: int
    processes: int
    folders: int

    def __str__(self) -> str:
        return (
            f"{self.memory:.1f} MB, {self.files} open files, {self.threads} threads, "
            f"{self.processes} processes, {self.folders} temporary folders"
        )


@dataclass(frozen=True)
class Soaked:
    """What was held early on and in the end, and the largest file that was written [bytes]."""

    what: str
    first: Held
    last: Held
    largest_file: int = 0

    def growth(self) -> float:
        """Memory in the end as a multiple of that early on."""
        return self.last.memory / self.first.memory

    def faults(self) -> list[str]:
        """What is beyond its bound."""
        found = []
        if self.growth() > BOUND:
            found.append(f"memory grew to {self.growth():.4f} of what it was")
        for kind in ("files", "threads", "processes", "folders"):
            before, after = getattr(self.first, kind), getattr(self.last, kind)
            if after > before:
                found.append(f"{kind}: {before}, then {after}")
        if self.largest_file > MOST_BYTES:
            found.append(f"a file of {self.largest_file} bytes")
        return found

    def __str__(self) -> str:
        return (
            f"{self.what}\n  first: {self.first}\n  last:  {self.last}\n"
            f"  memory x {self.growth():.4f}, largest file {self.largest_file / MEGABYTE:.1f} MB"
        )


def family(number: int) -> Iterator[int]:
    """Yield a process and all that it began, without those that have ended and are not waited for."""
    if Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
        return
    yield number
    for task in Path(f"/proc/{number}/task").iterdir():
        for child in (task / "children").read_text().split():
            yield from family(int(child))


def own(number: int) -> float:
    """
    Memory that a process has allocated, what it shares with others by its share [MB].

    Pages of libraries are left out: the share of them grows when a process of somebody else ends.
    """
    lines = Path(f"/proc/{number}/smaps_rollup").read_text().splitlines()
    return sum(int(line.split()[1]) for line in lines if line.startswith(("Pss_Anon:", "Pss_Shmem:"))) / 1024


def held() -> Held:
    """Look at what is held now."""
    gc.collect()
    processes = list(family(os.getpid()))
    return Held(
        memory=sum(map(own, processes)),
        files=len(os.listdir("/proc/self/fd")),
        threads=threading.active_count(),
        processes=len(processes),
        folders=len(os.listdir(tempfile.gettempdir())),
    )


class Looks:
    """Looks at what a run holds after some ticks, and again whenever it has done as many more."""

    def __init__(self, first: int) -> None:
        self.every = first
        self.done = 0
        self.seen: list[Held] = []
        self.threads = threading.active_count()

    def advance(self, ticks: int) -> None:
        """Note that some ticks have been done."""
        self.done += ticks
        if self.done < self.every * (len(self.seen) + 1):
            return
        if threading.active_count() > self.threads:  # which loads libraries that draw, as many as ever
            return
        with suppress(OSError):  # the process that steps may just have ended
            now = held()
            if not self.seen or now.processes == self.seen[0].processes:
                self.seen.append(now)
                sys.stderr.write(f"{self.done}: {now}\n")


def one_run(file: Path, number: int, what: str) -> Soaked:
    """Run a system into a folder, with a file of messages."""
    request = Request()
    experiment = prepare_to_run(file, request)
    described = Described(str(file), file, request, experiment, datetime.now(UTC))
    looks = Looks(max(1, min(FIRST_TICKS, number // 10)))
    with tempfile.TemporaryDirectory(prefix="dockloop-") as place:
        report, _ = run_into(described, Path(place) / "out", lambda: looks.advance, level="all")
        assert report.status == "completed", report.message
        largest = max(path.stat().st_size for path in (Path(place) / "out").iterdir())
    return Soaked(f"{number} ticks, {what}", looks.seen[0], looks.seen[-1], largest)


def small(folder: Path, number: int, deed: Deed) -> Path:
    """Write a system of two FMUs, of which one does a deed in each step."""
    faulty.build(folder)
    text = faulty.SYSTEM.format(
        stop=number / 1000, version=2, deed=deed, when=When.STEP, first=0, more="", order="[faulty, other]"
    )
    record = f"record: {{signals: [other.x], every: {max(1, number // MOST_ROWS)}}}\n"
    file = folder / "small.yaml"
    file.write_text(text + record)
    return file


def describe_wide() -> str:
    """Write the description of the FMU of many variables."""
    variables = []
    for i in range(2 * PORTS + LOCALS):
        causality = "input" if i < PORTS else "output" if i < 2 * PORTS else "local"
        start = ' start="0"' if causality == "input" else ""
        variables.append(
            f'<ScalarVariable name="v{i}" valueReference="{i}" causality="{causality}">'
            f"<Real{start}/></ScalarVariable>"
        )
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="wide" guid="wide">
  <CoSimulation modelIdentifier="wide"/>
  <ModelVariables>{"".join(variables)}</ModelVariables>
  <ModelStructure/>
</fmiModelDescription>
"""


def wide(folder: Path, number: int, n_fmus: int = FMUS) -> Path:
    """Write a ring of FMUs, each of whose outputs drives an input of the next one."""
    library = compile_c("2.0", folder, HERE / "wide.c", f"-DPORTS={PORTS}", "-w")
    write_fmu(folder / "wide.fmu", describe_wide(), {"linux64/wide.so": library})
    names = [f"f{i}" for i in range(n_fmus)]
    wires = [
        f"  - {{from: {one}.v{PORTS + k}, to: {other}.v{k}}}\n"
        for one, other in zip(names, [*names[1:], names[0]], strict=True)
        for k in range(PORTS)
    ]
    fmus = "".join(f"  {name}: {{source: wide.fmu}}\n" for name in names)
    file = folder / "wide.yaml"
    file.write_text(
        f"name: wide\nstep_size: 0.001\nstop_time: {number / 1000}\nfmus:\n{fmus}"
        f"coupling: {{order: [{', '.join(names)}]}}\nconnections:\n{''.join(wires)}"
        f"record: {{signals: [f0.v{PORTS}], every: {max(1, number // MOST_ROWS)}}}\n"
    )
    return file


def many(folder: Path, number: int, *, is_apart: bool) -> Soaked:
    """Load and run one system after the other, each with another parameter and length."""
    file = small(folder, 100, Deed.SAY)
    first: Held | None = None
    for i in range(number):
        if is_apart:
            request = Request(assignments=(f"faulty.first={i}",))
            experiment = prepare_to_run(file, request)
            described = Described(str(file), file, request, experiment, datetime.now(UTC))
            report, _ = run_into(described, folder / "out", lambda: lambda ticks: None, level="all")
            assert report.status == "completed"
        else:
            system = dockloop.load(file)
            assert (
                system.run(set={"faulty.first": i}, stop_time=0.01 + 0.001 * (i % 50)).status == "completed"
            )
            with system.open() as simulation:
                simulation.step(3)
        if i == max(1, number // 10):
            first = held()
    assert first is not None, "expected more systems"
    how = "each run in a process of its own" if is_apart else "in one process"
    return Soaked(f"{number} systems, {how}", first, held())


KINDS = {"ticks": 100_000_000, "messages": 10_000_000, "wide": 100_000, "systems": 10_000, "apart": 1000}


def soak(kind: str, number: int) -> Soaked:
    """Soak in one way, with temporary files in a folder of its own."""
    before = tempfile.tempdir
    with tempfile.TemporaryDirectory(prefix="dockloop-") as place:
        folder = Path(place) / "systems"
        own = Path(place) / "temporary"
        folder.mkdir()
        own.mkdir()
        tempfile.tempdir = str(own)
        try:
            if kind == "ticks":
                return one_run(small(folder, number, Deed.NOTHING), number, "two FMUs")
            if kind == "messages":
                return one_run(small(folder, number, Deed.COUNT_ALOUD), number, "another message each step")
            if kind == "wide":
                what = f"{FMUS} FMUs, {FMUS * PORTS} wires, {FMUS * (2 * PORTS + LOCALS)} variables"
                return one_run(wide(folder, number), number, what)
            return many(folder, number, is_apart=kind == "apart")
        finally:
            tempfile.tempdir = before


def main() -> None:
    """Soak and print what was held."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("kind", choices=list(KINDS))
    parser.add_argument("--number", type=int)
    chosen = parser.parse_args()
    soaked = soak(chosen.kind, chosen.number or KINDS[chosen.kind])
    sys.stdout.write(f"{soaked}\n")
    for fault in soaked.faults():
        sys.stdout.write(f"  {fault}\n")
    sys.exit(1 if soaked.faults() else 0)


if __name__ == "__main__":
    main()
