"""`dockloop case` drafts a case that passes its check, and marks what it guessed."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner

from master.cli import main
from master.diagnosis.case.case import read_case
from master.diagnosis.data.columns_picture import _chart
from master.diagnosis.data.draft import facts_of
from master.diagnosis.data.measured_signals import measured

N = 4000
T = np.round(5.0 + np.arange(N) * 0.002, 3)
FORCE = np.round(np.cos(3.0 * T), 2)


def recording(tmp_path, name="run.txt"):
    head = "Rig 7\nTime [s];Weg [mm];Load [kN];state\n"
    rows = zip(T, 10.0 * np.sin(3.0 * T), FORCE, strict=True)
    body = "".join(f"{t:.3f};{x:.6f};{f:.2f};on\n".replace(".", ",") for t, x, f in rows)
    path = tmp_path / name
    path.write_text(head + body, encoding="latin-1")
    return path


def draft(*arguments):
    return CliRunner().invoke(main, ["case", *map(str, arguments)])


def test_a_draft_passes_its_check_and_reads_the_signals_in_si(tmp_path):
    done = draft(recording(tmp_path), "--output", tmp_path / "case.yaml")
    checked = CliRunner().invoke(main, ["check", str(tmp_path / "case.yaml")])
    signals = measured(read_case(tmp_path / "case.yaml"))["run"]

    assert done.exit_code == 0
    assert "clock 'Time [s]': period 0.002 s, 0 gaps, 0 rows with jitter" in done.stdout
    assert "left out, not all numbers or of another length: 'state'" in done.stdout
    assert checked.exit_code == 0, checked.stderr
    np.testing.assert_allclose(signals["force"], 1e3 * FORCE, rtol=1e-12)
    middle = slice(N // 4, -N // 4)
    np.testing.assert_allclose(signals["der_q"][middle], 0.03 * np.cos(3.0 * T[middle]), atol=1e-5)


def test_steps_gaps_and_units_of_columns_are_told(tmp_path):
    path = recording(tmp_path)
    lines = path.read_text(encoding="latin-1").splitlines(keepends=True)
    path.write_text("".join(lines[:1000] + lines[1100:]), encoding="latin-1")
    facts = facts_of(path)
    way, load = facts.columns

    assert facts.clock is not None
    assert facts.clock.n_gaps == 1
    assert (way.unit, load.unit, load.source) == ("mm", "kN", "its name")
    assert load.step == pytest.approx(0.01)


def test_the_noise_of_a_column_is_told_with_its_evidence(tmp_path):
    rng = np.random.default_rng(4)
    way = np.where(T < 9.0, 0.0, np.sin(3.0 * (T - 9.0)))
    path = tmp_path / "rest.csv"
    noise = way + rng.normal(0.0, 0.01, N)
    path.write_text("t,way,load\n" + "".join(f"{t},{x},{f}\n" for t, x, f in zip(T, way, noise, strict=True)))
    load = facts_of(path).columns[1]

    assert load.evidence == "rest"
    assert load.floor == pytest.approx(0.01, rel=0.1)


def test_recordings_with_other_columns_are_refused_together_and_no_file_is_replaced(tmp_path):
    other = tmp_path / "other.csv"
    other.write_text("t,x\n" + "".join(f"{t},{t * t}\n" for t in T[:300]))
    output = tmp_path / "case.yaml"
    done = draft(recording(tmp_path), other, "--output", output)

    assert done.exit_code == 2
    assert "other.csv: columns, got ['x'], expected ['Weg [mm]', 'Load [kN]']" in done.stderr
    output.write_text("mine")
    assert draft(recording(tmp_path), "--output", output).exit_code == 2
    assert output.read_text() == "mine"


def test_all_columns_are_drawn_with_their_units_and_gaps(tmp_path):
    path = recording(tmp_path)
    lines = path.read_text(encoding="latin-1").splitlines(keepends=True)
    path.write_text("".join(lines[:1000] + lines[1100:]), encoding="latin-1")
    facts = facts_of(path)
    chart = _chart([facts], 0)

    assert [c.label for c in chart.curves] == ["Weg [mm]", "gaps of the clock: 1"]
    assert (chart.x_label, chart.y_label) == ("time since the first row [s]", "[mm]")
    assert chart.curves[1].x[0] == pytest.approx(
        997 * 0.002
    )  # 998 rows before it: two lines of 1000 are heads
    done = draft(path, "--output", tmp_path / "drawn.yaml")
    assert (tmp_path / "drawn.png").read_bytes().startswith(b"\x89PNG")
    assert f"{tmp_path / 'drawn.png'}: all columns" in done.stdout


def test_a_picture_that_is_there_is_not_replaced(tmp_path):
    (tmp_path / "case.png").write_text("mine")
    done = draft(recording(tmp_path), "--output", tmp_path / "case.yaml")

    assert (done.exit_code, (tmp_path / "case.png").read_text()) == (2, "mine")
    assert not (tmp_path / "case.yaml").exists()
