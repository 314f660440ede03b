"""Counters and angles that go over the ends of their range: recognised, followed, and said."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner

from master.cli import main
from master.diagnosis.case.case import load_case, read_case
from master.diagnosis.data.counts import unwrapped, wrap_of
from master.diagnosis.data.measured_signals import measured
from master.errors import ConfigError

T = 1e-3 * np.arange(4000)
ANGLE = 900.0 * np.sin(2.0 * np.pi * 0.4 * T) + 700.0 * T  # deg: several turns, both ways
NOISE = 0.05 * np.random.default_rng(2).standard_normal(len(T))


@pytest.mark.parametrize(
    ("values", "whole"),
    [
        (np.mod(ANGLE + NOISE, 360.0), 360.0),
        (np.mod(ANGLE + NOISE + 180.0, 360.0) - 180.0, 360.0),
        (np.mod(np.radians(ANGLE), 2.0 * np.pi), 2.0 * np.pi),
        (np.mod(np.round(10.0 * ANGLE), 3600.0), 3600.0),
        (np.mod(np.round(4096.0 * ANGLE / 360.0), 4096.0), 4096.0),
        (np.mod(np.round(65536.0 * ANGLE / 720.0), 65536.0), 65536.0),
        (np.mod(np.round(4096.0 * ANGLE / 360.0) + 2048.0, 4096.0) - 2048.0, 4096.0),
    ],
)
def test_a_counter_or_an_angle_that_wraps_is_recognised_and_followed(values, whole):
    found = wrap_of(values)

    assert found is not None
    assert found.whole == pytest.approx(whole)
    assert found.is_known
    assert found.times == np.sum(np.abs(np.diff(values)) > 0.5 * whole)
    scale = ANGLE.std() / found.followed(values).std()
    followed = scale * (found.followed(values) - found.followed(values)[0])
    assert np.abs(followed - (ANGLE - ANGLE[0])).max() < 0.5


def test_an_unusual_range_is_read_from_the_jumps():
    found = wrap_of(np.mod(np.round(10_000.0 * ANGLE / 360.0), 10_000.0))

    assert found.whole == pytest.approx(10_000.0, rel=0.005)
    assert not found.is_known


def test_counts_around_zero_that_are_read_without_a_sign_are_two_s_complement():
    found = wrap_of(np.mod(np.round(50.0 * np.sin(3.0 * T) + 0.2), 65536.0))

    assert found.entry == "bits: 16"


@pytest.mark.parametrize(
    "values",
    [
        ANGLE,
        np.sign(np.sin(9.0 * T)) + NOISE,
        180.0 * np.sign(np.sin(9.0 * T)) + NOISE,
        np.where(T > 2.0, 5.0, 0.0) + NOISE,
        100.0 * NOISE,
        np.where(np.arange(4000) % 500 == 7, 400.0, 0.0) + np.sin(T),
        np.round(200.0 * np.sin(6.0 * T)),
        np.full(4000, 3.0),
    ],
    ids=["angle", "square", "half turns", "step", "noise", "spikes", "counts", "constant"],
)
def test_what_jumps_without_going_over_the_ends_of_a_range_does_not_wrap(values):
    assert wrap_of(values) is None


def test_values_beyond_the_range_are_refused():
    with pytest.raises(ValueError, match="wraps, got values that span 720, expected 360 at most"):
        unwrapped(np.linspace(0.0, 720.0, 500), 360.0)


def written(folder):
    """Angle in deg that wraps, and what follows it."""
    table = np.column_stack([T, np.mod(ANGLE, 360.0), np.gradient(np.radians(ANGLE), T), np.cos(T)])
    header = "t [s],phi [deg],w [rad/s],tau [N m]"
    np.savetxt(folder / "run.csv", table, delimiter=",", header=header, comments="", fmt="%.10g")
    return folder / "run.csv"


def test_a_draft_follows_a_wrapped_angle_and_says_so(tmp_path):
    case = tmp_path / "case.yaml"
    told = CliRunner().invoke(main, ["case", str(written(tmp_path)), "--output", str(case)])
    text = case.read_text(encoding="utf-8")

    assert told.exit_code == 0, told.output
    assert "over the ends of a range of 360" in told.output
    (line,) = [own for own in text.splitlines() if "phi" in own and "column" in own and "#" in own]
    assert "wraps: 360" in line
    assert "guess" in line
    (recording,) = measured(read_case(case)).values()
    (name,) = [key for key, entry in read_case(case).case.signals.items() if entry.column == "phi [deg]"]
    # but for the low-pass of the draft
    assert recording[name] - recording[name][0] == pytest.approx(np.radians(ANGLE - ANGLE[0]), abs=2e-3)
    times = int(np.sum(np.abs(np.diff(np.mod(ANGLE, 360.0))) > 180.0))
    assert f"followed {times} times over the ends of its range of 360, " in " ".join(recording.notes)
    assert " of 4000 rows changed" in " ".join(recording.notes)


def test_a_case_that_takes_a_wrapped_angle_as_it_is_is_told(tmp_path):
    case = tmp_path / "case.yaml"
    CliRunner().invoke(main, ["case", str(written(tmp_path)), "--output", str(case)])
    case.write_text(case.read_text(encoding="utf-8").replace(", wraps: 360", ""), encoding="utf-8")
    (recording,) = measured(read_case(case)).values()

    assert "taken as it is: write wraps: 360" in " ".join(recording.notes)


@pytest.mark.parametrize(
    ("given", "said"), [("wraps: true", "got no bits"), ("wraps: 8, bits: 3", "range and")]
)
def test_a_range_and_bits_exclude_each_other(given, said, tmp_path):
    case = tmp_path / "case.yaml"
    CliRunner().invoke(main, ["case", str(written(tmp_path)), "--output", str(case)])
    case.write_text(case.read_text(encoding="utf-8").replace("wraps: 360", given), encoding="utf-8")

    with pytest.raises(ConfigError, match=said):
        load_case(case)
