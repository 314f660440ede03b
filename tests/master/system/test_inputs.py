"""Inputs that a recording drives: the bits that an FMU gives which steps first, or every fault of it."""

import json

import numpy as np
import pyarrow as pa
import pytest
from click.testing import CliRunner
from pyarrow import parquet
from scipy.io import savemat

from master.analysis.closed_loop.linearise import Linearisation
from master.cli import main
from master.errors import ConfigError
from master.experiment.prepare import prepare
from master.recording.files import read_csv
from tests.stubs import Block, variables

N = 40
T = 0.25 * np.arange(N + 1)
U = np.random.default_rng(3).normal(size=N + 1)

SYSTEM = """\
name: test
step_size: 0.25
stop_time: 10.0
fmus: {{source: {{source: table.fmu}}, a: {{source: integrator.fmu}}, b: {{source: integrator.fmu}}}}
coupling: {{order: [source, a, b]}}
connections: [{{from: source.y, to: a.u}}]
{inputs}
"""
GIVEN = "inputs: {{file: {file}, time: {{column: t{unit}}}, map: {{b.u: {{column: F}}}}{more}}}"


def table():
    """An FMU that gives the samples at the communication points."""
    return Block(lambda t, h, v: {"y": float(U[round((t + h) / 0.25)])}, variables(("y", "output")))


@pytest.fixture
def write(bay):
    bay.made["table"] = table()
    (bay.folder / "table.fmu").touch()

    def make(t=T, u=U, kind="csv", unit="", more=""):
        file = bay.folder / f"stimulus.{kind}"
        if kind == "csv":
            rows = [f"{a!r},{b!r}" for a, b in zip(t.tolist(), u.tolist(), strict=True)]
            file.write_text("\n".join(["t,F", *rows]) + "\n")
        elif kind == "npz":
            np.savez(file, t=t, F=u)
        elif kind == "mat":
            savemat(file, {"t": t, "F": u})
        else:
            parquet.write_table(pa.table({"t": t, "F": u}), file)
        return bay.write(SYSTEM.format(inputs=GIVEN.format(file=file.name, unit=unit, more=more)))

    return make


@pytest.fixture
def run(bay):
    def call(path):
        out = bay.folder / "out"
        result = CliRunner().invoke(main, ["run", str(path), "--json", "--output", str(out)])
        assert result.exit_code == 0, result.output
        return read_csv(out / "result.csv")

    return call


@pytest.mark.parametrize("kind", ["csv", "npz", "mat", "parquet"])
def test_values_of_a_recording_have_the_bits_that_an_fmu_gives(write, run, kind):
    rows = run(write(kind=kind))

    assert np.any(rows["a.x"] != rows["a.x"][0])
    assert np.array_equal(rows["a.x"], rows["b.x"])


@pytest.mark.parametrize(("unit", "factor"), [("ms", 1e3), ("s", 1.0), ("us", 1e6)])
def test_times_in_other_units_are_at_the_same_ticks(write, run, unit, factor):
    rows = run(write(t=T * factor, unit=f", unit: {unit}"))

    assert np.array_equal(rows["a.x"], rows["b.x"])


def values(path):
    return prepare(path).inputs.values[:, 0]


def test_between_samples_the_last_one_is_held(write):
    found = values(write(t=np.array([-1.0, 2.0, 2.6]), u=np.array([1.0, 2.0, 3.0])))

    # 2.0 s is tick 8; 2.6 s is in tick 10, so that tick 11 is the first one after it
    assert found.tolist() == [1.0] * 8 + [2.0] * 3 + [3.0] * 30


def test_between_samples_a_line_is_followed(write):
    linear = ", interpolation: linear"
    found = values(write(t=np.array([0.0, 10.0]), u=np.array([1.0, 3.0]), more=linear))

    assert found == pytest.approx(np.linspace(1.0, 3.0, N + 1), abs=1e-15)


def test_a_sample_at_a_tick_is_exact_however_its_time_is_rounded(write):
    """0.1 + 0.2 is 0.30000000000000004, and 1000.3 ms is no double: no sample slips to the next tick."""
    path = write(t=np.arange(0, 100_001) * 0.1, u=np.arange(100_001.0), unit=", unit: ms")
    text = path.read_text().replace("step_size: 0.25", "step_size: 0.0001")
    path.write_text(text)

    assert np.array_equal(values(path), np.arange(100_001.0))


def test_the_ledger_lists_an_input_like_a_wire(write):
    entries = {e.target: e for e in prepare(write()).ledger.entries}

    assert (entries["b.u"].source, entries["b.u"].least, entries["b.u"].most) == ("stimulus.csv: F", 0, 0)


@pytest.mark.parametrize("every", [1, 2])
def test_a_step_that_uses_the_value_at_its_start_is_one_step_of_its_fmu_behind_one_at_its_end(write, every):
    rates = ("b: {source: integrator.fmu}", f"b: {{source: integrator.fmu, every: {every}}}")
    late, early = write(more=", at: start"), None
    late.write_text(late.read_text().replace(*rates))
    entry = next(e for e in prepare(late).ledger.entries if e.target == "b.u")
    late = values(late)
    early = write()
    early.write_text(early.read_text().replace(*rates))

    assert late.tolist() == [U[0]] * every + U[:-every].tolist()
    assert values(early).tolist() == U.tolist()
    assert (entry.least, entry.most) == (every, every)


FAULTS = [
    ({"t": T[::-1]}, "", "expected it to grow"),
    ({"u": np.where(T == 1.0, np.nan, U)}, "", "row 6, column 'F': got nan, expected a number"),
    ({"t": T + 1.0}, "", "begins at 1 s, expected a sample at or before the start, 0 s"),
    ({"t": T[:9], "u": U[:9], "more": ", interpolation: linear"}, "", "ends at 2 s, expected a sample at or"),
    ({"unit": ", unit: m"}, "", "not a time, got 'm'"),
    ({}, "column: F|column: G", "no such column, got 'G', expected one of t, F"),
    ({}, "b.u:|b.v:", "no such input, got 'v', expected one of u"),
    ({}, "b.u:|c.u:", "no such FMU, got 'c'"),
    ({}, "b.u:|a.u:", "has two sources, got 'a.u' again"),
    ({}, "file: stimulus.csv|file: missing.csv", "no such file"),
    ({}, "{column: F}|{column: F, unit: parsec}", "parsec"),
    ({}, "interpolation: hold|interpolation: cubic", "interpolation"),
]


@pytest.mark.parametrize(("given", "change", "said"), FAULTS)
def test_a_fault_of_a_recording_is_named_with_its_line(write, given, change, said):
    given = {"more": ", interpolation: hold", **given}
    path = write(**given)
    if change:
        path.write_text(path.read_text().replace(*change.split("|")))
    with pytest.raises(ConfigError) as caught:
        prepare(path)

    assert all(p.startswith(f"{path}:7: inputs") for p in caught.value.problems)
    assert any(said in p for p in caught.value.problems), caught.value.problems


@pytest.mark.parametrize(
    ("inputs", "said"),
    [
        ("{file: a.csv}", ["inputs.time: missing", "inputs.map: missing"]),
        ("{}", ["inputs.file: missing", "inputs.time: missing", "inputs.map: missing"]),
        ("[{file: a.csv}]", ["inputs[0].time: missing", "inputs[0].map: missing"]),
        ("{fiel: a.csv, time: {column: t}, map: {b.u: {column: F}}}", ["inputs.fiel: unknown key", "'file'"]),
        ("{b.u: F}", ["inputs.b.u: unknown key, got 'F', expected one of file, time, map"]),
        ("a.csv", ["inputs: not a list"]),
    ],
)
def test_an_entry_that_lacks_something_is_refused_with_all_that_it_lacks(bay, inputs, said):
    path = bay.write(SYSTEM.format(inputs=f"inputs: {inputs}"))
    with pytest.raises(ConfigError) as caught:
        prepare(path)

    for text in said:
        assert text in str(caught.value)


@pytest.fixture
def in_newton(write):
    def make(unit):
        path = write()
        text = path.read_text().replace("b: {source: integrator.fmu}", "b: {source: newton.fmu}")
        path.write_text(text.replace("{column: F}", f"{{column: F, unit: {unit}}}"))
        return path

    return make


def test_units_are_converted(in_newton):
    assert np.array_equal(values(in_newton("kN")), 1e3 * U)


def test_a_unit_of_another_quantity_is_refused(in_newton):
    with pytest.raises(ConfigError, match="unit does not fit, got 'kg', expected N"):
        prepare(in_newton("kg"))


def test_explain_prints_the_input(write):
    result = CliRunner().invoke(main, ["explain", str(write()), "--json"])

    assert {"stimulus.csv: F"} <= {c["from"] for c in json.loads(result.stdout)["connections"]}


def test_an_analysis_says_that_inputs_keep_their_first_values(write, bay):
    found = Linearisation(prepare(write()), factory=bay.factory)

    assert [vars(a) for a in found.assumptions] == [
        {"signal": "b.u", "value": U[0], "reason": "first value of the recording stimulus.csv: F"}
    ]
    assert found.system.instances["b"].start["u"] == U[0]
