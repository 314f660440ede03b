"""`dockloop check` of a case: every fault at once, or what a diagnosis would work on."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from master.cli import main

CASES = Path(__file__).parents[4] / "configs" / "measured"


def check(*arguments):
    return CliRunner().invoke(main, ["check", *map(str, arguments)])


def test_a_valid_case_says_its_rows_parts_and_effects():
    done = check(CASES / "first_case.yaml", "--json")
    found = json.loads(done.stdout)

    assert done.exit_code == 0
    assert found["rows"] == {"run": 4000}
    (part,) = found["parts"]
    assert part["compared"] == ["axis.force"]
    assert part["effects"] == 3
    assert found["fit"] + found["select"] < 4000


def test_faults_of_the_case_its_system_and_its_recording_are_said_together(tmp_path):
    text = (CASES / "first_case.yaml").read_text(encoding="utf-8")
    (tmp_path / "recordings").mkdir()
    for old, new in (("servo_axis_inverse", "servo_axis_invers"), ("column: ", "column: no ")):
        assert old in text
        text = text.replace(old, new)
    recording = CASES / "recordings" / "first_case.csv"
    (tmp_path / "recordings" / "first_case.csv").write_bytes(recording.read_bytes())
    (tmp_path / "wrong.yaml").write_text(text + "nonsense: 1\n", encoding="utf-8")
    done = check(tmp_path / "wrong.yaml")

    assert done.exit_code == 2
    for fault in ("nonsense", "servo_axis_invers", "column for "):
        assert fault in done.stderr


@pytest.mark.parametrize("option", [("--variant", "none"), ("--step-size", "0.01")])
def test_options_of_a_system_are_refused_for_a_case(option):
    done = check(CASES / "first_case.yaml", *option)

    assert done.exit_code == 2
    assert f"got {option[0]}, expected no option of a system" in done.stderr


def test_a_check_filters_no_signal_and_still_refuses_a_filter_that_cannot_be(tmp_path, monkeypatch):
    text = (CASES / "first_case.yaml").read_text(encoding="utf-8")
    (tmp_path / "recordings").mkdir()
    recording = CASES / "recordings" / "first_case.csv"
    (tmp_path / "recordings" / "first_case.csv").write_bytes(recording.read_bytes())
    signal = next(line for line in text.splitlines() if "column: force" in line or "force: {column" in line)
    for lowpass, status in ((20, 0), (1e6, 2)):
        filtered = signal.replace("}", f", lowpass: {lowpass}}}")
        (tmp_path / "case.yaml").write_text(text.replace(signal, filtered), encoding="utf-8")
        monkeypatch.setattr("scipy.signal.butter", lambda *given, **named: pytest.fail("a filter was made"))
        done = check(tmp_path / "case.yaml")

        assert done.exit_code == status, done.output
    assert "lowpass: got 1e+06 Hz, expected less than " in done.stderr
