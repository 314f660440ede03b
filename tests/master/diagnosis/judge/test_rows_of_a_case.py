"""A case with two loggers, gaps, counts, values of each recording: what is done is told, the answer right."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

from master.cli import main

CASE = """
name: two_loggers
fmus: {{axis: {{source: servo_axis_inverse, parameters: {{mass: 90, damping: 150}}}}}}
recordings:
  one: {{file: motion_1.csv, merge: {{file: force_1.csv, signals: [force], delay: {delay}}}}}
  two: {{file: motion_2.csv, merge: {{file: force_2.csv, signals: [force], delay: {delay}}}}}
time: {{column: t, gaps: split}}
signals:
  q: {{column: q, unit: um, bits: 20, lowpass: 80}}
  der_q: {{rate_of: q}}
  der_der_q: {{rate_of: der_q}}
  force: {{column: f, unit: N}}
inputs: {{axis.q: q, axis.der_q: der_q, axis.der_der_q: der_der_q}}
compared: {{axis.force: force}}
refit:
  axis.mass: {{low: 10, high: 1000}}
  axis.damping: {{low: 0, high: 1000}}
per_recording: [axis.damping]
slots: {{axis.friction: [coulomb, quadratic_damping]}}
split: {{blocks: [fit, select, fit, sealed, fit, select, fit, select, fit, sealed, fit, select], guard: 0.05}}
"""


def write(folder, number, damping, delay):
    rng = np.random.default_rng(number)
    t = np.arange(6000) * 1e-3

    def force(t):
        v = 0.28 * np.cos(5.6 * t) + 0.24 * np.cos(14.0 * t)
        a = -0.28 * 5.6 * np.sin(5.6 * t) - 0.24 * 14.0 * np.sin(14.0 * t)
        return 100.0 * a + damping * v + 20.0 * np.sign(v)

    q = np.round(1e6 * (0.05 * np.sin(5.6 * t) + 0.24 / 14.0 * np.sin(14.0 * t)))
    kept = (t < 2.0) | (t > 2.3)
    rows = np.column_stack([t, np.mod(q, 2.0**20)])[kept]
    np.savetxt(folder / f"motion_{number}.csv", rows, "%.9g", ",", header="t,q", comments="")
    other = np.arange(4900) * 1.237e-3
    rows = np.column_stack([other, force(other - delay) + 0.5 * rng.standard_normal(4900)])
    np.savetxt(folder / f"force_{number}.csv", rows, "%.9g", ",", header="t,f", comments="")


def told(folder, delay="{low: -0.02, high: 0.02}"):
    write(folder, 1, 100.0, 0.004)
    write(folder, 2, 300.0, 0.004)
    (folder / "case.yaml").write_text(CASE.format(delay=delay), encoding="utf-8")
    done = CliRunner().invoke(main, ["check", str(folder / "case.yaml"), "--json"])
    assert done.exit_code == 0, done.stderr
    return json.loads(done.stdout)


def test_check_says_what_was_done_to_how_many_rows(tmp_path):
    found = told(tmp_path)

    assert found["rows"].keys() == {"one[1]", "one[2]", "two[1]", "two[2]"}
    notes = " ".join(found["notes"]["one[1]"])
    assert "'q': read as 20 bits in two's complement" in notes
    assert "gaps: 1, the longest of 0.301 s" in notes
    assert "merged: force of the second logger, 4900 rows every 0.001237 s" in notes
    assert abs(float(notes.partition("delay ")[2].partition(" +-")[0]) - 0.004) < 2e-4


def test_a_value_of_a_recording_that_no_model_has_is_refused(tmp_path):
    write(tmp_path, 1, 100.0, 0.0)
    write(tmp_path, 2, 100.0, 0.0)
    text = CASE.format(delay="0.0").replace("file: motion_1.csv", "file: motion_1.csv, set: {axis.mas: 3}")
    text = text.replace("per_recording: [axis.damping]", "per_recording: [axis.no_damping]")
    (tmp_path / "case.yaml").write_text(text, encoding="utf-8")
    done = CliRunner().invoke(main, ["check", str(tmp_path / "case.yaml")])

    assert done.exit_code == 2
    assert "recordings.one.set.axis.mas: no such variable, got 'mas'" in done.stderr
    assert "per_recording[0]: no parameter to refit, got 'axis.no_damping'" in done.stderr


@pytest.mark.long
def test_each_recording_has_its_own_damping_and_the_friction_is_named(tmp_path):
    told(tmp_path)
    done = CliRunner().invoke(
        main, ["diagnose", str(tmp_path / "case.yaml"), "--output", str(tmp_path / "answer"), "--json"]
    )
    found = json.loads(done.stdout)
    fitted = {name: p["with_effect"] for name, p in found["parameters"].items()}

    assert [e["effect"] for e in found["effects"]] == ["coulomb"]
    assert fitted["axis.damping@one"] == pytest.approx(100.0, abs=8.0)
    assert fitted["axis.damping@two"] == pytest.approx(300.0, abs=8.0)
    assert fitted["axis.mass"] == pytest.approx(100.0, rel=0.02)
    assert found["recordings"]["one[1]"]["notes"]
