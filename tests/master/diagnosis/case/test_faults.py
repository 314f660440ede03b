"""Faults that a case shows only beside its system and its recordings."""

from __future__ import annotations

import copy

import numpy as np
import pytest
import yaml

from master.diagnosis.case.case import load_case
from master.diagnosis.data.measured_signals import opened
from master.errors import ConfigError

N = 1000
CASE = {
    "name": "axis",
    "fmus": {"axis": {"source": "servo_axis_inverse"}},
    "recordings": {"run": "run.npz"},
    "time": {"column": "t"},
    "signals": {
        "q": {"column": "pos", "unit": "mm"},
        "v": {"column": "vel", "unit": "mm/s"},
        "a": {"rate_of": "v"},
        "f": {"column": "force", "unit": "N"},
    },
    "inputs": {"axis.q": "q", "axis.der_q": "v", "axis.der_der_q": "a"},
    "compared": {"axis.force": "f"},
    "refit": {"axis.mass": {"low": 10, "high": 200}},
    "split": {"blocks": ["fit", "select", "sealed"], "guard": 0.05},
}


@pytest.fixture
def folder(tmp_path):
    t = np.arange(N) * 1e-3
    columns = {"t": t, "pos": 1e2 * np.sin(3 * t), "vel": 3e2 * np.cos(3 * t), "force": np.cos(3 * t)}
    np.savez(tmp_path / "run.npz", **columns)
    np.savez(tmp_path / "holed.npz", **columns | {"force": np.where(t == t[7], np.nan, 1.0)})
    return tmp_path


def faults(folder, **changed):
    """Faults of the case with some keys changed, `a__b` for b in a, without their places."""
    case = copy.deepcopy(CASE)
    for key, value in changed.items():
        *path, last = key.split("__")
        inner = case
        for name in path:
            inner = inner[name]
        inner[last] = value
    (folder / "case.yaml").write_text(yaml.safe_dump(case))
    with pytest.raises(ConfigError) as caught:
        opened(load_case(folder / "case.yaml"))
    problems = [p.removeprefix(f"{folder / 'case.yaml'}:") for p in caught.value.problems]
    return [p.partition(": ")[2].replace(f"{folder}/", "") for p in problems]


def test_case_without_a_fault_is_opened(folder):
    (folder / "case.yaml").write_text(yaml.safe_dump(CASE))
    system, recordings = opened(load_case(folder / "case.yaml"))

    assert system.parts[0].fmus == ("axis",)
    assert len(recordings["run"]) == N


def test_faults_of_system_and_recordings_are_reported_at_once(folder):
    found = faults(
        folder,
        recordings={"run": "run.npz", "gone": "gone.csv", "holed": "holed.npz"},
        refit={"axis.mas": {"low": 1, "high": 2}},
        slots={"axis.friction": "coulom"},
    )

    assert [line.partition(", expected")[0] for line in found] == [
        "refit.axis.mas: no such variable, got 'mas'",
        "slots.axis.friction: no such effect, got 'coulom'",
        "recordings.gone: gone.csv: no such file",
        "recordings.holed: holed.npz: row 7, column 'force': got nan",
    ]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"slots": {"axis.fric": "all"}}, "slots.axis.fric: no such slot, got 'fric', expected 'friction'"),
        ({"slots": {"axis.q": "coulomb"}}, "slots.axis.q: the slot has no signals for it, got 'coulomb'"),
        ({"starts": {"axis.x": [0, 1]}}, "starts.axis.x: no such variable, got 'x'"),
        ({"starts": {"axis.q": [1, 0]}}, "starts.axis.q: low is not below high, got 1.0 and 0.0"),
        ({"replay": {"windows": {"axle": 1}}}, "replay.windows.axle: no such FMU, got 'axle'"),
        ({"set": {"axis.mass": "much"}}, "set.axis.mass: value not allowed, got 'much', expected a number"),
        ({"refit": {"axis.force": {"low": 0, "high": 1}}}, "refit.axis.force: not a parameter, got output"),
        (
            {"refit__axis.mass__low": 100},
            "refit.axis.mass: value of the system, got 95.1, expected 100",
        ),
        ({"refit__axis.mass__low": -5}, "refit.axis.mass: low, got -5, expected at least 0"),
        ({"inputs__axis.mass": "f"}, "inputs.axis.mass: not an input, got parameter axis.mass"),
        ({"compared__axis.q": "q"}, "compared.axis.q: not an output, got input axis.q"),
        ({"inputs": {"axis.q": "q", "axis.der_q": "v"}}, "inputs: axis.der_der_q is not driven"),
        ({"inputs": {"axis.q": "q", "axisder_q": "v"}}, "inputs.axisder_q: not an 'instance.variable'"),
        (
            {"signals__f__unit": "kN m"},
            "signals.f.unit: not the unit of axis.force, got 'kN m'",
        ),
        (
            {"signals__v__unit": "m/s"},
            "recordings.run: run.npz: v is not the rate of q: its integral",
        ),
        (
            {"signals__q__lowpass": 600},
            "recordings.run: signals.q.lowpass: got 600 Hz, expected less",
        ),
        ({"replay": {"cut": 500}}, "replay.cut: got 500 rows off both ends of 'run'"),
        (
            {"recordings__run": {"file": "run.npz", "rows": [0, 2000]}},
            "recordings.run: run.npz: rows, got",
        ),
        ({"split": {p: ["run"] for p in ("fit", "select", "sealed")}}, "split: 'run' is used 3 times"),
        ({"split__sealed": ["run"]}, "split: all recordings are sealed, expected one to cut into blocks"),
        ({"signals__f__scale": 0}, "signals.f: scale, got 0, expected another number"),
    ],
)
def test_fault_says_what_is_wrong_and_what_was_expected(changed, message, folder):
    found = faults(folder, **changed)

    assert any(line.startswith(message) for line in found), found


def test_a_column_of_a_recording_is_for_a_signal_that_has_one(folder):
    recordings = {"run": {"file": "run.npz", "columns": {"f": "other", "a": "pos", "g": "pos"}}}
    found = faults(folder, recordings=recordings)
    [missing] = faults(folder, recordings={"run": {"file": "run.npz", "columns": {"f": "other"}}})

    assert found[0].endswith("columns.a: no signal with a column, got 'a', expected one of f, q, v")
    assert "columns.g: no signal with a column, got 'g', expected" in found[1]
    assert "got 'other', expected one of" in missing


def test_recordings_of_one_file_have_columns_of_their_own(folder):
    case = copy.deepcopy(CASE)
    case["recordings"] = {
        "run": "run.npz",
        "again": {"file": "run.npz", "columns": {"f": "pos"}},
    }
    (folder / "case.yaml").write_text(yaml.safe_dump(case))
    _, recordings = opened(load_case(folder / "case.yaml"))

    t = np.arange(N) * 1e-3
    assert recordings["run"]["f"] == pytest.approx(np.cos(3 * t))
    assert recordings["again"]["f"] == pytest.approx(1e2 * np.sin(3 * t))
