"""
Random inputs of every kind that a user writes: each ends with exit status 0, 2, 3 or 4, in time, in words.

    python -m tests.reliability.fuzz_inputs [--number 10000] [--seed 1] [--kind yaml]

Inputs are mutations of valid ones, drawn from a seed: systems and events in YAML, `--set`, cases, recordings
(CSV, JSON, NPZ, Parquet) as `--inputs`, and command lines. A fault is an exception, another exit status, no
message on a refusal, or more than 10 s. An input that failed once is kept in `corpus/` and tried each time.
"""

from __future__ import annotations

import argparse
import random
import shutil
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyarrow as pa
from click.testing import CliRunner
from pyarrow import parquet

from master.cli import COMMANDS, main

PROJECT = Path(__file__).parents[2]
CORPUS = Path(__file__).parent / "corpus"
LONGEST = 10.0
ALLOWED = (0, 2, 3, 4)
SYSTEM = """\
name: test
step_size: 0.001
stop_time: 0.01
fmus:
  mass: {source: spacecraft.fmu, parameters: {m_s: 2.0}, start: {v_des: 1.0}}
  sensor: {source: force_sensor.fmu, every: 2, parameters: {seed: 4, sigma: 0.2}}
coupling: {order: [mass, sensor]}
connections:
  - {from: sensor.f_mea, to: mass.f, delay: 2, extrapolation: 1}
variants: {heavy: {mass: {m_s: 5}}}
limits: {mass.s_des: 10}
record: {signals: [mass.s_des], every: 3}
"""
EVENTS = """\
events:
  - {at: 0.002, jitter: {mass.f: 5}, seed: 7, duration: 0.003}
  - {at: 0.003, offset: {mass.f: 0.5}}
  - {when: mass.s_des > 0.05, set: {sensor.sigma: 0.5}, duration: 0.1}
  - {at: 0.004, freeze: [mass.f]}
"""
CSV = "t,F,g\n0,1,2\n0.005,2,3\n0.01,3,4\n"
WORDS = (
    *("null", "~", "true", "1e999", "-0", "nan", ".inf", "0x10", "[]", "{}", "''", '"', "'", "&a", "*a"),
    *("!!int", "!!python/object:os.system x", "? a", ": ", "- ", "\t", "\u0000", "\u202e", "é" * 50),
    *("9" * 400, "a" * 5000, "mass", "mass.f", "sensor", "events", "-1", "0", "1e-300", "9" * 20, "../.."),
    *("file:///etc", "2026-11-30", "1:30", "1_000", "=cmd()", "\x1b[31m", "<b>", "%s%n", "{{7*7}}"),
    *("${HOME}", "|", ">", "#"),
)
OPTIONS = (
    *("--variant", "--set", "--stop-time", "--step-size", "--every", "--record", "--json", "--output"),
    *("--checkpoint", "--real-time", "--core", "--priority", "--tolerance", "--inputs", "--log", "--help"),
)
SETTINGS = ("mass.m_s=3", "sensor.seed=5", "mass.v_des=[1]", "step_size=0.002", "sensor.sigma=1e-3")
LASTING = ("reproduce", "build", "doctor", "diagnose", "compare-methods")


@dataclass
class Found:
    """Number of inputs by exit status, the slowest [s], and the faults."""

    inputs: int = 0
    statuses: dict[int, int] = field(default_factory=dict)
    slowest: float = 0.0
    faults: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        by = ", ".join(f"{n} with {status}" for status, n in sorted(self.statuses.items()))
        return f"{self.inputs} inputs ({by}), slowest {self.slowest:.1f} s, {len(self.faults)} faults"


def mutated(text: str, draw: random.Random) -> str:
    """Change a text in one to four places."""
    for _ in range(draw.randint(1, 4)):
        i = draw.randrange(len(text) + 1)
        j = min(len(text), i + draw.choice((0, 1, 2, 5, 20)))
        kind = draw.randrange(5)
        if kind == 0:
            text = text[:i] + draw.choice(WORDS) + text[j:]
        elif kind == 1:
            text = text[:i] + text[j:]
        elif kind == 2:
            text = text[:j] + text[i:]
        elif kind == 3:
            tokens = [*text.replace("{", " { ").replace(":", ": ").split(" ")]
            tokens[draw.randrange(len(tokens))] = draw.choice(WORDS)
            text = " ".join(tokens)
        else:
            lines = text.splitlines(keepends=True)
            draw.shuffle(lines)
            text = "".join(lines[:i] + lines[i // 2 :])[:20_000]
    return text


def write(path: Path, text: str) -> Path:
    """Write a text whatever characters it has."""
    path.write_bytes(text.encode("utf-8", errors="surrogatepass"))
    return path


def yaml(folder: Path, draw: random.Random) -> list[str]:
    """A system."""
    return ["check", str(write(folder / "system.yaml", mutated(SYSTEM, draw)))]


def events(folder: Path, draw: random.Random) -> list[str]:
    """Events of a system."""
    return ["check", str(write(folder / "system.yaml", SYSTEM + mutated(EVENTS, draw)))]


def settings(folder: Path, draw: random.Random) -> list[str]:
    """Values on the command line."""
    valid = draw.choice(
        ("mass.m_s=3", "sensor.seed=5", "mass.v_des=[1]", "step_size=0.002", "sensor.sigma=1e-3")
    )
    words = ["check", str(write(folder / "system.yaml", SYSTEM))]
    for _ in range(draw.randint(1, 3)):
        words += ["--set", mutated(valid, draw)]
    return words


def case(folder: Path, draw: random.Random) -> list[str]:
    """A case of the diagnosis."""
    text = (PROJECT / "configs" / "measured" / "first_case.yaml").read_text(encoding="utf-8")
    return ["check", str(write(folder / "case.yaml", mutated(text, draw)))]


def recording(folder: Path, draw: random.Random) -> list[str]:
    """A table that drives inputs."""
    ending = draw.choice(("csv", "json", "npz", "parquet", "mat", "txt"))
    path = folder / f"table.{ending}"
    if ending == "npz":
        np.savez(path, t=np.arange(3.0), F=np.arange(3.0))
    elif ending == "parquet":
        parquet.write_table(pa.table({"t": [0.0, 1.0], "F": [1.0, 2.0]}), path)
    else:
        text = '[{"t": 0, "F": 1}, {"t": 1, "F": 2}]' if ending == "json" else CSV
        write(path, mutated(text, draw))
    if ending in ("npz", "parquet") and draw.random() < 0.8:
        data = bytearray(path.read_bytes())
        for _ in range(draw.randint(1, 8)):
            data[draw.randrange(len(data))] = draw.randrange(256)
        path.write_bytes(data[: draw.choice((len(data), draw.randrange(len(data))))])
    columns = "time: {column: t, unit: s}, map: {sensor.f_act: {column: F, unit: N}}"
    inputs = f"inputs: {{file: {path.name}, {columns}}}\n"
    return ["check", str(write(folder / "system.yaml", SYSTEM + inputs))]


def command(folder: Path, draw: random.Random) -> list[str]:
    """A command line; commands that run, build or search for long get no file that exists."""
    system = str(write(folder / "system.yaml", SYSTEM))
    name = draw.choice([name for name in COMMANDS if name not in LASTING])
    words = [name, system if name in ("check", "explain", "show", "inspect") else str(folder / "no.yaml")]
    for _ in range(draw.randint(0, 4)):
        words.append(draw.choice((*OPTIONS, *(w for w in WORDS if "\0" not in w))))
    if "--output" in words or name in ("show", "new", "examples", "schema"):
        words = [name, str(folder / "nowhere" / "x"), *(w for w in words[2:] if w != "--output")]
    return words


KINDS: dict[str, Callable[[Path, random.Random], list[str]]] = {
    "yaml": yaml,
    "events": events,
    "settings": settings,
    "case": case,
    "recording": recording,
    "command": command,
}


def tried(words: list[str], found: Found) -> str:
    """Run a command; return what is wrong, empty if nothing is."""
    begin = time.monotonic()
    cpu = time.process_time()
    done = CliRunner().invoke(main, words)
    seconds = min(time.monotonic() - begin, time.process_time() - cpu + 1.0)
    found.inputs += 1
    found.slowest = max(found.slowest, seconds)
    found.statuses[done.exit_code] = found.statuses.get(done.exit_code, 0) + 1
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        return "".join(traceback.format_exception(done.exception)[-2:])
    if done.exit_code not in ALLOWED:
        return f"exit status {done.exit_code}"
    if done.exit_code == 2 and not done.stderr.strip() and not done.stdout.strip():
        return "no message"
    if "Traceback" in done.output:
        return "a traceback"
    return f"{seconds:.1f} s" if seconds > LONGEST else ""


def inputs(kind: str, number: int, seed: int) -> Iterator[tuple[str, random.Random]]:
    """Names and generators of the inputs of a kind: each can be drawn alone."""
    for i in range(number):
        name = f"{kind}-{seed}-{i}"
        yield name, random.Random(name)


def main_(number: int = 10_000, seed: int = 1, kind: str | None = None) -> Found:
    """Try some inputs of each kind."""
    found = Found()
    kinds = [kind] if kind else list(KINDS)
    with tempfile.TemporaryDirectory(prefix="dockloop-") as place:
        folder = Path(place)
        for name in ("spacecraft.fmu", "force_sensor.fmu"):
            shutil.copy(PROJECT / "fmus" / name, folder)
        for text in sorted(CORPUS.glob("*.yaml")):
            shutil.copy(text, folder / "system.yaml")
            if said := tried(["check", str(folder / "system.yaml")], found):
                found.faults.append(f"{text.name}: {said}")
        for one in kinds:
            for name, draw in inputs(one, -(-number // len(kinds)), seed):
                if said := tried(KINDS[one](folder, draw), found):
                    found.faults.append(f"{name}: {said}")
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--number", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", choices=list(KINDS))
    result = main_(**vars(parser.parse_args()))
    sys.stdout.write("".join(f"{line}\n" for line in result.faults))
    sys.stdout.write(f"{result}\n")
    sys.exit(1 if result.faults else 0)
