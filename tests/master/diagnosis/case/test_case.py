from __future__ import annotations

import numpy as np
import pytest

from master.diagnosis.case.case import filled, load_case
from master.diagnosis.data.measured_signals import measured
from master.errors import ConfigError, DataError

CASE = """\
name: small
fmus: {axis: {source: servo_axis_inverse}}
recordings: {run: {file: run.npz}}
time: {column: t, unit: s}
signals:
  q: {column: pos, unit: mm}
  der_q: {rate_of: q}
inputs: {axis.q: q, axis.der_q: {signal: der_q, at: end}}
compared: {axis.force: q}
split: {blocks: [fit, select, sealed], guard: 0.1}
"""


def write(folder, text=CASE, **columns):
    t = np.arange(1000) * 1e-3
    np.savez(folder / "run.npz", t=t, pos=1e3 * t**2, **columns)
    path = folder / "case.yaml"
    path.write_text(text)
    return path


def faults(path):
    with pytest.raises(ConfigError) as caught:
        measured(load_case(path))
    return [problem.removeprefix(f"{path}:") for problem in caught.value.problems]


def test_case_is_read(tmp_path):
    case = load_case(write(tmp_path)).case

    assert case.inputs["axis.q"].signal == "q"
    assert case.inputs["axis.q"].at is None
    assert case.inputs["axis.der_q"].at == "end"
    assert case.split.guard == 0.1


def test_signals_are_in_si_units_and_differentiated(tmp_path):
    r = measured(load_case(write(tmp_path)))["run"]

    assert r["q"][500] == pytest.approx(0.25)
    assert r["der_q"][500] == pytest.approx(1.0)


def test_recording_without_time_has_its_period(tmp_path):
    text = CASE.replace("{column: t, unit: s}", "{period: 0.002}")
    r = measured(load_case(write(tmp_path, text)))["run"]

    assert r.period == pytest.approx(0.002)


def test_all_faults_of_a_case_are_reported_at_once(tmp_path):
    text = CASE.replace("axis.q: q", "axis.q: w").replace("axis.force: q", "axis.force: f")

    assert faults(write(tmp_path, text)) == [
        "8: inputs.axis.q: no such signal, got 'w', expected one of q, der_q",
        "9: compared.axis.force: no such signal, got 'f', expected one of q, der_q",
    ]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "at: end",
            "at: noon",
            "8: inputs.axis.der_q.at: not one of the choices, got 'noon', expected 'start' or 'end'",
        ),
        ("select, sealed", "sealed", "10: split: blocks, got no select, expected fit, select and sealed"),
        ("rate_of: q", "scale: 2", "7: signals.der_q: a signal has either 'column' or 'rate_of'"),
        ("fmus:", "nodes:", "2: nodes: unknown key, got a mapping, expected"),
        (
            "{rate_of: q}",
            "{rate_of: der_q}",
            "3: recordings.run: signals: made from each other",
        ),
        ("column: pos", "column: way", "3: recordings.run: "),
    ],
)
def test_fault_names_its_line(old, new, message, tmp_path):
    found = faults(write(tmp_path, CASE.replace(old, new)))

    assert any(line.startswith(message) for line in found), found


def test_file_name_takes_the_environment(monkeypatch):
    monkeypatch.setenv("DOCKLOOP_DATA", "elsewhere")

    assert filled("${DOCKLOOP_DATA}/a.mat") == "elsewhere/a.mat"


@pytest.mark.parametrize("unset", [True, False], ids=["unset", "empty"])
def test_a_variable_without_a_value_says_what_to_set(unset, tmp_path, monkeypatch):
    if unset:
        monkeypatch.delenv("DOCKLOOP_DATA", raising=False)
    else:
        monkeypatch.setenv("DOCKLOOP_DATA", "")
    path = write(tmp_path, CASE.replace("file: run.npz", 'file: "${DOCKLOOP_DATA}/emps/run.npz"'))

    [problem] = faults(path)

    assert problem.startswith("3: recordings.run: ${DOCKLOOP_DATA}/emps/run.npz: environment variable")
    assert "DOCKLOOP_DATA: not set, got none, expected the folder" in problem


def test_all_variables_that_are_not_set_are_named(monkeypatch):
    monkeypatch.delenv("ONE_FOLDER", raising=False)
    monkeypatch.delenv("ANOTHER_FOLDER", raising=False)

    with pytest.raises(DataError) as caught:
        filled("${ONE_FOLDER}/${ANOTHER_FOLDER}/${ONE_FOLDER}.csv")

    assert len(str(caught.value).splitlines()) == 2
