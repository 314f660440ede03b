"""
Inputs of every kind that a user has, each a change of a valid one.

A kind writes a file or more into a folder, and returns the words of the command that reads it.
"""

from __future__ import annotations

import io
import json
import random
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import yaml as yaml_
from click.testing import CliRunner
from pyarrow import parquet
from scipy.io import savemat

from master.cli import COMMANDS, main
from tests.stubs.descriptions import XML, XML_3

from .mutations import WORDS, mutated, mutated_bytes, mutated_tree, mutated_xml

PROJECT = Path(__file__).parents[2]
CORPUS = Path(__file__).parent / "corpus"
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
JSON = '[{"t": 0, "F": 1}, {"t": 1, "F": 2}]'
OPTIONS = (
    *("--variant", "--set", "--stop-time", "--step-size", "--every", "--record", "--json", "--output"),
    *("--checkpoint", "--real-time", "--core", "--priority", "--tolerance", "--inputs", "--log", "--help"),
)
SETTINGS = (
    *("mass.m_s=3", "sensor.seed=5", "mass.v_des=[1]", "step_size=0.002", "sensor.sigma=1e-3"),
    *("sensor.sigma=50 mN", "mass.m_s=2 kg", "mass.integrator=leapfrog", "sensor.f_mea->mass.f.delay=3"),
)
LASTING = ("reproduce", "build", "doctor", "diagnose", "compare-methods")
READING = ("check", "explain", "show", "inspect")
_RUNS = 0.1


def prepare(folder: Path) -> None:
    """Put what the inputs are made of into a folder; what a run compiles is compiled then."""
    _without_sources(PROJECT / "fmus" / "spacecraft.fmu", folder / "spacecraft.fmu")
    _without_sources(PROJECT / "fmus" / "force_sensor.fmu", folder / "force_sensor.fmu")
    _without_sources(PROJECT / "fmus" / "fmi3" / "spacecraft.fmu", folder / "spacecraft3.fmu")
    recordings = folder / "recordings"
    recordings.mkdir()
    whole = (PROJECT / "configs" / "measured" / "recordings" / "first_case.csv").read_text(encoding="utf-8")
    (recordings / "whole.csv").write_text(whole, encoding="utf-8")
    valid = str(write(folder / "valid.yaml", SYSTEM))
    for words in (["export-ssp", valid, "--output", "valid.ssp"], ["run", valid, "--output", "valid"]):
        done = CliRunner().invoke(main, [*words[:-1], str(folder / words[-1])])
        assert done.exit_code == 0, done.output


def _without_sources(source: Path, target: Path) -> None:
    """Copy an FMU with what a run on this system needs of it."""
    with zipfile.ZipFile(source) as whole, zipfile.ZipFile(target, "w") as small:
        for name in whole.namelist():
            if name == "modelDescription.xml" or name.startswith(
                ("binaries/linux64", "binaries/x86_64-linux")
            ):
                small.writestr(name, whole.read(name))


def write(path: Path, text: str) -> Path:
    """Write a text whatever characters it has."""
    path.write_bytes(text.encode("utf-8", errors="surrogatepass"))
    return path


def changed_yaml(text: str, draw: random.Random) -> str:
    """Change the values of a YAML, or its text."""
    if draw.random() < 0.4:
        return mutated(text, draw)
    tree = mutated_tree(yaml_.safe_load(text), draw)
    return yaml_.safe_dump(
        tree, allow_unicode=True, sort_keys=False, default_flow_style=draw.choice((None, True))
    )


def with_member(archive: Path, name: str, content: bytes, target: Path) -> Path:
    """Copy an archive, with other content of a member."""
    with zipfile.ZipFile(archive) as source, zipfile.ZipFile(target, "w") as made:
        for member in source.namelist():
            made.writestr(member, content if member == name else source.read(member))
    return target


def member(archive: Path, name: str) -> bytes:
    """Read a member of an archive."""
    with zipfile.ZipFile(archive) as source:
        return source.read(name)


def yaml(folder: Path, draw: random.Random) -> list[str]:
    """A system."""
    return ["check", str(write(folder / "system.yaml", changed_yaml(SYSTEM, draw)))]


def events(folder: Path, draw: random.Random) -> list[str]:
    """Events of a system."""
    return ["check", str(write(folder / "system.yaml", SYSTEM + changed_yaml(EVENTS, draw)))]


def settings(folder: Path, draw: random.Random) -> list[str]:
    """Values on the command line."""
    words = ["check", str(write(folder / "system.yaml", SYSTEM))]
    for _ in range(draw.randint(1, 3)):
        words += ["--set", mutated(draw.choice(SETTINGS), draw)]
    return words


def case(folder: Path, draw: random.Random) -> list[str]:
    """A case of the diagnosis."""
    text = (PROJECT / "configs" / "measured" / "first_case.yaml").read_text(encoding="utf-8")
    text = text.replace("first_case.csv", "whole.csv")
    return ["check", str(write(folder / "case.yaml", changed_yaml(text, draw)))]


def recording(folder: Path, draw: random.Random) -> list[str]:
    """A table that drives inputs, or that a case is drafted from."""
    ending = draw.choice(("csv", "json", "npz", "parquet", "mat", "txt"))
    path = folder / f"table.{ending}"
    path.write_bytes(_table(ending, draw))
    if draw.random() < 0.2:
        drafted = folder / "draft.yaml"
        drafted.unlink(missing_ok=True)
        drafted.with_suffix(".png").unlink(missing_ok=True)
        return ["case", str(path), "--output", str(drafted)]
    columns = "time: {column: t, unit: s}, map: {sensor.f_act: {column: F, unit: N}}"
    inputs = f"inputs: {{file: {path.name}, {columns}}}\n"
    return ["check", str(write(folder / "system.yaml", SYSTEM + inputs))]


def _table(ending: str, draw: random.Random) -> bytes:
    """Return a table in a format, with a fault or, in a fifth of those in binary, odd values."""
    if ending in ("csv", "txt"):
        return mutated(CSV, draw).encode("utf-8", errors="surrogatepass")
    if ending == "json":
        if draw.random() < 0.5:
            return mutated(JSON, draw).encode("utf-8", errors="surrogatepass")
        return json.dumps(mutated_tree(json.loads(JSON), draw)).encode()
    t, force = _columns(draw)
    file = io.BytesIO()
    if ending == "parquet":
        n = min(t.size, force.size)
        parquet.write_table(pa.table({"t": t.ravel()[:n], "F": force.ravel()[:n]}), file)
    elif ending == "mat":
        savemat(file, {"t": t, "F": force}, do_compression=draw.random() < 0.5)
    else:
        np.savez(file, t=t, F=force)
    return mutated_bytes(file.getvalue(), draw) if draw.random() < 0.8 else file.getvalue()


def _columns(draw: random.Random) -> tuple[np.ndarray, np.ndarray]:
    kinds = ("f8", "f4", "i8", "u1", "U3", "?", "M8[ns]", "f2")
    t = np.arange(3.0)
    force = np.arange(float(draw.choice((3, 3, 3, 0, 1, 4)))).astype("i8").astype(draw.choice(kinds))
    if draw.random() < 0.2:
        t = np.array(draw.choice(([0, 0, 1], [2, 1, 0], [0, np.nan, 1], [0, np.inf, 1], [0, 1e300, 1e308])))
    return t, force


def description_2(folder: Path, draw: random.Random) -> list[str]:
    """A model description of FMI 2.0."""
    return _description(folder, draw, "spacecraft.fmu", XML)


def description_3(folder: Path, draw: random.Random) -> list[str]:
    """A model description of FMI 3.0."""
    return _description(folder, draw, "spacecraft3.fmu", XML_3)


def _description(folder: Path, draw: random.Random, valid: str, rich: str) -> list[str]:
    name = "modelDescription.xml"
    target = folder / "changed.fmu"
    if draw.random() < 0.3:
        return ["inspect", str(with_member(folder / valid, name, mutated_xml(rich, draw), target))]
    content = mutated_xml(member(folder / valid, name).decode(), draw)
    with_member(folder / valid, name, content, target)
    system = write(folder / "system.yaml", SYSTEM.replace("spacecraft.fmu", target.name))
    if draw.random() < _RUNS:
        results = folder / "results"
        shutil.rmtree(results, ignore_errors=True)
        return ["run", str(system), "--output", str(results)]
    return ["check", str(system)]


def archive(folder: Path, draw: random.Random) -> list[str]:
    """The bytes of an FMU or of an SSP archive."""
    valid = folder / draw.choice(("spacecraft.fmu", "spacecraft3.fmu", "valid.ssp"))
    data = valid.read_bytes()
    directory = data.rfind(b"PK\x01\x02", 0, data.rfind(b"PK\x05\x06"))
    at = draw.choice((0, max(0, len(data) - 600), max(0, directory - 200)))  # where the structure is
    target = folder / f"changed{valid.suffix}"
    target.write_bytes(data[:at] + mutated_bytes(data[at : at + 600], draw) + data[at + 600 :])
    return ["inspect" if valid.suffix == ".fmu" else "check", str(target)]


def ssp(folder: Path, draw: random.Random) -> list[str]:
    """The structure, or values, of an SSP archive."""
    valid = folder / "valid.ssp"
    name = draw.choice(("SystemStructure.ssd", "SystemStructure.ssd", "resources/mass.ssv"))
    content = mutated_xml(member(valid, name).decode(), draw)
    return ["check", str(with_member(valid, name, content, folder / "changed.ssp"))]


def command(folder: Path, draw: random.Random) -> list[str]:
    """A command line; commands that run, build or search for long get no file that exists."""
    system = str(write(folder / "system.yaml", SYSTEM))
    name = draw.choice([name for name in COMMANDS if name not in LASTING])
    words = [name, system if name in READING else str(folder / "no.yaml")]
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
    "description 2": description_2,
    "description 3": description_3,
    "archive": archive,
    "ssp": ssp,
    "command": command,
}
