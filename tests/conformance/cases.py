"""
Foreign FMUs and systems with the results that others published: each case runs the command and judges.

Expected values come from the publishers' files and, where there are none, from the models' equations:
Feedthrough hands inputs to outputs, LinearTransform gives y = scalar A u + offset.
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from click.testing import CliRunner
from scipy.integrate import solve_ivp

from master.cli import main

from .material import FOLDER, build_pythonfmu3, pack_ssp

RELATIVE = 1e-9
PASSED = "pass"
REFUSED = "refused"


@dataclass(frozen=True)
class Finding:
    """What became of a case: `pass`, `refused` where that is right, or what is wrong."""

    status: str
    remark: str = ""

    @property
    def is_right(self) -> bool:
        return self.status in (PASSED, REFUSED)


@dataclass(frozen=True)
class Case:
    """One row of the table: `judge` runs it in a folder, with the Reference FMUs by FMI version."""

    group: str
    name: str
    fmi: str
    judge: Callable[[Mapping[str, Path], Path], Finding]

    @property
    def title(self) -> str:
        return f"{self.group}: {self.name}, FMI {self.fmi}"


@dataclass(frozen=True)
class Run:
    """One call of `dockloop run`: exit status, all it said, columns of its CSV by name without unit."""

    status: int
    said: str
    columns: Mapping[str, np.ndarray]


def run(system: Path, folder: Path, *options: str) -> Run:
    """Run a system from the command and read its CSV."""
    output = folder / "out"
    done = CliRunner().invoke(main, ["run", str(system), "--output", str(output), *options])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        return Run(1, f"traceback: {done.exception!r}", {})
    file = output / "result.csv"
    return Run(done.exit_code, done.output + done.stderr, read_csv(file) if file.is_file() else {})


def read_csv(path: Path, delimiter: str = ",") -> dict[str, np.ndarray]:
    """Columns of numbers by name; the unit in brackets is left off, true and false are 1 and 0."""
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file, delimiter=delimiter)
    names = [re.sub(r"\s+\[[^]]*\]\s*$", "", h).strip() for h in header]
    columns = dict(zip(names, zip(*rows, strict=True), strict=True))
    return {name: numbers for name, cells in columns.items() if (numbers := _numbers(cells)) is not None}


def _numbers(cells: tuple[str, ...]) -> np.ndarray | None:
    truths = {"false": "0", "true": "1", "False": "0", "True": "1"}
    try:
        return np.array([float(truths.get(c, c)) for c in cells])
    except ValueError:
        return None


def alone(fmu: Path, stop: float, step: float, folder: Path, start: Mapping[str, Any] | None = None) -> Run:
    """Run one FMU by itself."""
    entry: dict[str, Any] = {"source": str(fmu)} | ({"start": dict(start)} if start else {})
    system = {"name": "alone", "step_size": step, "stop_time": stop, "fmus": {"fmu": entry}}
    path = folder / "alone.yaml"
    path.write_text(yaml.safe_dump(system), encoding="utf-8")
    return run(path, folder)


def far(got: np.ndarray, expected: np.ndarray) -> float:
    """Largest relative difference; the expectation's largest magnitude is the scale near zero."""
    scale = np.maximum(np.abs(expected), 1e-6 * max(1.0, float(np.max(np.abs(expected)))))
    return float(np.max(np.abs(got - expected) / scale))


def judged(done: Run, differences: Mapping[str, float], bound: float = RELATIVE) -> Finding:
    """Pass if the run ended well and every signal is as published."""
    if done.status != 0:
        return Finding("failed", done.said.strip().splitlines()[-1])
    if not differences:
        return Finding("failed", "no signal to compare")
    worst = max(differences, key=lambda name: differences[name])
    if not differences[worst] <= bound:
        return Finding("wrong", f"{worst} off by {differences[worst]:.3g}")
    return Finding(PASSED, f"{len(differences)} signals, largest difference {differences[worst]:.1e}")


def published(
    model: str, fmi: str, stop: float, step: float, fmus: Mapping[str, Path], folder: Path
) -> Finding:
    """Compare a Reference FMU with its published result: of rows at one time the last one counts."""
    done = alone(fmus[fmi] / f"{model}.fmu", stop, step, folder)
    expected = read_csv(FOLDER / "reference-fmus" / model / f"{model}_out.csv")
    if not done.columns:
        return judged(done, {})
    time = expected.pop("time")
    rows = [int(np.flatnonzero(np.abs(time - t) < 1e-6 * step)[-1]) for t in done.columns["time"]]
    differences = {
        name: far(done.columns[f"fmu.{name}"], column[rows])
        for name, column in expected.items()
        if f"fmu.{name}" in done.columns
    }
    return judged(done, differences)


FEEDTHROUGH = {
    "2.0": {
        "Float64_continuous": 1.5,
        "Float64_discrete": -2.5,
        "Int32": -2147483647,
        "Boolean": True,
        "Enumeration": 2,
    },
    "3.0": {
        "Float32_continuous": 0.25,
        "Float32_discrete": -0.75,
        "Float64_continuous": 1.5,
        "Float64_discrete": -2.5,
        "Int8": -127,
        "UInt8": 255,
        "Int16": -32767,
        "UInt16": 65535,
        "Int32": -2147483647,
        "UInt32": 4294967295,
        "Int64": -9007199254740991,
        "UInt64": 9007199254740991,
        "Boolean": True,
        "Enumeration": 2,
    },
}


def fed_through(fmi: str, fmus: Mapping[str, Path], folder: Path) -> Finding:
    """Every type: the output is the input."""
    inputs = {f"{name}_input": value for name, value in FEEDTHROUGH[fmi].items()}
    done = alone(fmus[fmi] / "Feedthrough.fmu", 0.5, 0.1, folder, inputs)
    if not done.columns:
        return judged(done, {})
    outputs = {name: done.columns[f"fmu.{name}_output"][-1:] for name in FEEDTHROUGH[fmi]}
    return judged(done, {n: far(got, np.array([float(FEEDTHROUGH[fmi][n])])) for n, got in outputs.items()})


def state_space(fmus: Mapping[str, Path], folder: Path) -> Finding:
    """Arrays against the published result, which writes an array as one cell."""
    done = alone(fmus["3.0"] / "StateSpace.fmu", 10.0, 1.0, folder)
    with (FOLDER / "reference-fmus" / "StateSpace" / "StateSpace_out.csv").open(newline="") as file:
        rows = [row[1].split() for row in list(csv.reader(file))[1:]]
    expected = np.array(rows, dtype=float)
    if not done.columns:
        return judged(done, {})
    return judged(
        done, {f"y[{i + 1}]": far(done.columns[f"fmu.y[{i + 1}]"], expected[:, i]) for i in range(3)}
    )


def robertson(fmus: Mapping[str, Path], folder: Path) -> Finding:
    """
    Robertson's kinetics against a stiff solver; the FMU itself steps by explicit Euler of 1e-6 s.

    Its published file is a copy of BouncingBall's.
    """

    def rate(t: float, y: np.ndarray) -> list[float]:
        slow, fast, pair = 0.04 * y[0], 1e4 * y[1] * y[2], 3e7 * y[1] * y[1]
        return [-slow + fast, slow - fast - pair, pair]

    done = alone(fmus["3.0"] / "Roberts.fmu", 0.4, 1e-3, folder)
    exact = solve_ivp(rate, (0.0, 0.4), [1.0, 0.0, 0.0], method="Radau", rtol=1e-10, atol=1e-14).y[:, -1]
    if not done.columns:
        return judged(done, {})
    got = {f"y{i + 1}": done.columns[f"fmu.y{i + 1}"][-1:] for i in range(3)}
    return judged(done, {n: far(v, exact[[i]]) for i, (n, v) in enumerate(got.items())}, bound=1e-4)


def refused(model: str, words: tuple[str, ...], fmus: Mapping[str, Path], folder: Path) -> Finding:
    """Pass if the FMU is refused with exit status 2 and a message that has these words."""
    done = alone(fmus["3.0"] / f"{model}.fmu", 1.0, 0.1, folder)
    message = done.said.strip().splitlines()[-1]
    if done.status != 2 or not all(word in message for word in words):
        return Finding("wrong", f"exit {done.status}, {message}")
    return Finding(REFUSED, message.rpartition(": ")[2])


def mastersim(scheme: str, order: list[Any], fmus: Mapping[str, Path], folder: Path) -> Finding:
    """
    MasterSim's control loop, steps of 0.01 s to t = 10 s.

    It adds up its time (t += 0.01), so that a pulse's edge at t = 3, 5, ... comes one row later there: rows
    before t = 3 agree, and over the whole run x1, x2 and x3 differ in at most four rows, x4 by at most 0.06.
    """
    parts = FOLDER / "mastersim" / "Math_003" / "fmus"
    wires = [
        ("Part1.x1", "Part2.x1"),
        ("Part1.x2", "Part2.x2"),
        ("Part3.x4", "Part2.x4"),
        ("Part2.x3", "Part3.x3"),
    ]
    system = {
        "name": "control_loop",
        "step_size": 0.01,
        "stop_time": 10.0,
        "fmus": {p.stem: {"source": str(p)} for p in sorted(parts.glob("*.fmu"))},
        "coupling": {"order": order},
        "connections": [{"from": source, "to": target} for source, target in wires],
    }
    path = folder / "control_loop.yaml"
    path.write_text(yaml.safe_dump(system), encoding="utf-8")
    done = run(path, folder)
    golden = parts.parent / "results" / f"{scheme}_1iters_fixedStep.csv"
    expected = read_csv(golden, delimiter="\t")
    if not done.columns:
        return judged(done, {})
    before = {n: far(done.columns[n][:300], e[:300]) for n, e in expected.items() if n in done.columns}
    shown = judged(done, before)
    for name in ("Part1.x1", "Part1.x2", "Part2.x3"):
        rows = int(np.sum(np.abs(done.columns[name] - expected[name]) > 1e-9))
        if rows > 4:
            return Finding("wrong", f"{name} differs in {rows} rows, expected at most 4")
    off = float(np.max(np.abs(done.columns["Part3.x4"] - expected["Part3.x4"])))
    return (
        shown
        if off <= 0.06 * (1 + RELATIVE)
        else Finding("wrong", f"Part3.x4 off by {off:.3g}, expected at most 0.06")
    )


def all_types(fmus: Mapping[str, Path], folder: Path) -> Finding:
    """PythonFMU3's alltypes: outputs follow inputs of each type."""
    given = {"uint64": 7, "float64": 1.25, "boolean": True, "int32": -3, "int64": -5}
    fmu = build_pythonfmu3("alltypes", folder / "build")
    done = alone(fmu, 0.3, 0.1, folder, {f"{name}_input": value for name, value in given.items()})
    if not done.columns:
        return judged(done, {})
    return judged(
        done,
        {n: far(done.columns[f"fmu.{n}_output"][-1:], np.array([float(v)])) for n, v in given.items()},
    )


def linear_transform(fmus: Mapping[str, Path], folder: Path) -> Finding:
    """PythonFMU3's linearTransform: y = scalar A u + offset, A and the vectors at their start values."""
    fmu = build_pythonfmu3("linearTransform", folder / "build")
    done = alone(fmu, 0.3, 0.1, folder)
    a = np.array([[1.0, 1.0], [2.0, 1.0]])
    expected = 2.0 * a @ np.array([1.0, 2.0]) + np.array([1.0, 2.0])
    if not done.columns:
        return judged(done, {})
    return judged(
        done, {f"y[{i + 1}]": far(done.columns[f"fmu.y[{i + 1}]"][-1:], expected[[i]]) for i in range(2)}
    )


def bouncing_ball(fmus: Mapping[str, Path], folder: Path) -> Finding:
    """PythonFMU3's bouncingBall: its own semi-explicit recursion, repeated here."""
    fmu = build_pythonfmu3("bouncingBall", folder / "build")
    done = alone(fmu, 1.0, 0.01, folder)
    height, speed, gravity = 1.0, 0.0, -9.81
    heights = [height]
    for _ in range(100):
        height, speed = height + speed * 0.01, speed + gravity * 0.01
        if height <= 0.0 and speed < 0.0:
            height, speed = 1e-12, -0.7 * speed
        heights.append(height)
    if not done.columns:
        return judged(done, {})
    return judged(done, {"ball.h": far(done.columns["fmu.ball.h"], np.array(heights))})


def array_types(fmus: Mapping[str, Path], folder: Path) -> Finding:
    """PythonFMU3's arraytypes: random outputs of every type, of which the ranges are known."""
    fmu = build_pythonfmu3("arraytypes", folder / "build")
    done = alone(fmu, 0.5, 0.1, folder)
    if done.status != 0:
        return judged(done, {})
    real = np.array([done.columns[f"fmu.float64_output[{i + 1}]"][1:] for i in range(10)])
    whole = np.array([done.columns[f"fmu.int32_output[{i + 1}]"][1:] for i in range(10)])
    right = (
        bool(((real > 0) & (real < 1)).all())
        and len(np.unique(real)) == real.size
        and bool(((whole >= 0) & (whole < 100)).all())
    )
    return (
        Finding(PASSED, "ranges of random outputs")
        if right
        else Finding("wrong", "a value is out of its range")
    )


def ssp(case: Path, fmi: str, fmus: Mapping[str, Path], folder: Path) -> Finding:
    """An SSP archive: values in the last row, or refused with these words."""
    expected = json.loads((case / "expected.json").read_text(encoding="utf-8"))
    archive = pack_ssp(case, fmus[fmi], expected.get("pack", {}), folder)
    done = run(archive, folder)
    if "refused" in expected:
        if done.status == 2 and all(word in done.said for word in expected["refused"]):
            return Finding(REFUSED, f"names {', '.join(expected['refused'])}")
        return Finding("wrong", f"exit {done.status}, {done.said.strip().splitlines()[-1]}")
    if not done.columns:
        return judged(done, {})
    plain = {re.sub(r"[^A-Za-z0-9_]+", ".", name): column for name, column in done.columns.items()}
    missing = [name for name in expected["at_stop"] if name not in plain]
    if missing:
        return Finding("wrong", f"no column {missing[0]}")
    return judged(done, {n: far(plain[n][-1:], np.array([float(v)])) for n, v in expected["at_stop"].items()})


def all_cases() -> list[Case]:
    """Every case, in the order of the table."""
    cases = [
        Case("Reference FMUs", model, fmi, partial(published, model, fmi, stop, step))
        for fmi in ("2.0", "3.0")
        for model, stop, step in (
            ("BouncingBall", 3.0, 0.01),
            ("Dahlquist", 10.0, 0.1),
            ("Feedthrough", 2.0, 0.1),
            ("Resource", 1.0, 1.0),
            ("Stair", 10.0, 0.2),
            ("VanDerPol", 20.0, 0.01),
        )
    ]
    cases += [
        Case("Reference FMUs", "Feedthrough, every type set", f, partial(fed_through, f))
        for f in ("2.0", "3.0")
    ]
    cases += [
        Case("Reference FMUs", "StateSpace", "3.0", state_space),
        Case("Reference FMUs", "Roberts, against a stiff solver", "3.0", robertson),
        Case(
            "Reference FMUs", "Clocks (scheduled execution)", "3.0",
            partial(refused, "Clocks", ("scheduled execution",)),
        ),
        Case(
            "MasterSim", "control loop, Gauss-Jacobi", "2.0",
            partial(mastersim, "GaussJacobi", [["Part1", "Part2", "Part3"]]),
        ),
        Case(
            "MasterSim", "control loop, Gauss-Seidel", "2.0",
            partial(mastersim, "GaussSeidel", ["Part1", "Part2", "Part3"]),
        ),
        Case("PythonFMU3", "alltypes", "3.0", all_types),
        Case("PythonFMU3", "arraytypes", "3.0", array_types),
        Case("PythonFMU3", "bouncingBall", "3.0", bouncing_ball),
        Case("PythonFMU3", "linearTransform", "3.0", linear_transform),
    ]  # fmt: skip
    for fmi in ("2.0", "3.0"):
        for case in sorted((FOLDER / "ssp" / "cases").iterdir()):
            cases.append(Case("SSP 1.0", case.name, fmi, partial(ssp, case, fmi)))
    return cases
