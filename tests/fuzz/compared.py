"""A random system through the command and through the bare loop: the same rows, or what differs."""

from __future__ import annotations

import csv
import zipfile
from pathlib import Path

import numpy as np
import yaml
from click.testing import CliRunner

from master.cli import main

from .bare_loop import step_through
from .systems import N_STEPS, Fmu, H, RandomSystem, describe, layout, random_system, text

FOLDERS = {"2.0": "linux64", "3.0": "x86_64-linux"}
CONVERTED = 1e-10  # the two convert units with one rounding more or less, which the mixers amplify
SOURCE = Path(__file__).with_name("mixer.c")


def compile_mixer(folder: Path) -> dict[str, bytes]:
    """Compile the slave for both FMI versions; what FMPy binds and the mixer lacks answers with an error."""
    from tests.foreign.build import compile_c

    return {v: compile_c(v, folder, SOURCE, f"-DFMI={v[0]}", "-lm") for v in FOLDERS}


def difference(seed: int, binaries: dict[str, bytes], folder: Path) -> str:
    """Say how the command's rows differ from the bare loop's; empty if they do not."""
    system = random_system(seed)
    archives = {f.name: _write(f, binaries[f.version], folder) for f in system.fmus}
    expected = step_through(system, archives, folder / "unpacked")
    path = folder / "system.yaml"
    path.write_text(_yaml(system, archives), encoding="utf-8")
    done = CliRunner().invoke(main, ["run", str(path), "--output", str(folder / "out")])
    if done.exit_code != 0:
        said = done.stderr.strip().splitlines() or [repr(done.exception)]
        return f"exit {done.exit_code}: {said[-1]}"
    with (folder / "out" / "result.csv").open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    got = dict(zip(header, np.array(rows, dtype=float).T, strict=True))
    missing = sorted(set(expected) - set(got))
    if missing:
        return f"no column {missing[0]!r}, columns {header}"
    converts = any(w.output.unit != w.input.unit for w in system.wires)
    bound = CONVERTED if converts else 0.0
    for name, column in expected.items():
        off = np.abs(got[name] - column) / np.maximum(1.0, np.abs(column))
        if not off.max() <= bound:
            k = int(off.argmax())
            return f"{name!r} row {k}: got {got[name][k]!r}, expected {column[k]!r}"
    return ""


def _write(fmu: Fmu, binary: bytes, folder: Path) -> Path:
    path = folder / f"{fmu.name}.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", describe(fmu))
        archive.writestr("resources/layout.txt", layout(fmu))
        archive.writestr(f"binaries/{FOLDERS[fmu.version]}/mixer.so", binary)
    return path


def _yaml(system: RandomSystem, archives: dict[str, Path]) -> str:
    fmus = {}
    for fmu in system.fmus:
        entry: dict[str, object] = {"source": str(archives[fmu.name])}
        for section, role in (("parameters", "p"), ("start", "i")):
            kinds = {name: v for v in fmu.having(role) for name in v.names}
            values = {n: _value(kinds[n], x) for n, x in system.given[fmu.name].items() if n in kinds}
            if values:
                entry[section] = values
        fmus[fmu.name] = entry
    wires = []
    for w in system.wires:
        wire: dict[str, object] = {
            "from": f"{w.source.name}.{w.source_name}",
            "to": f"{w.target.name}.{w.target_name}",
        }
        wires.append(wire | ({"delay": w.delay} if w.delay else {}))
    document = {
        "name": "random",
        "step_size": H,
        "stop_time": round(N_STEPS * H, 9),
        "fmus": fmus,
        "coupling": {"order": [g[0] if len(g) == 1 else list(g) for g in system.order]},
    }
    if wires:
        document["connections"] = wires
    return yaml.safe_dump(document, allow_unicode=True, sort_keys=False)


def _value(v, values: tuple[float, ...]) -> object:
    typed = [yaml.safe_load(text(v.kind, x)) for x in values]
    if v.kind == "Enumeration":
        typed = [f"item{x}" for x in typed]
    return typed if v.shape else typed[0]
