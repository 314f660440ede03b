"""The nine measures by hand, and records in the forms that people have them in."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.io import savemat

from master.errors import DataError
from master.rths.benchmark import DEVIATIONS, perturbed
from master.rths.measures import Motions, lag, measures
from master.rths.record import read_record

H = 1.0 / 4096.0


def test_each_measure_by_hand():
    target = np.array([0.0, 1.0, 0.0, -1.0])
    wave = np.column_stack([target, 2.0 * target, 4.0 * target])
    floors = np.column_stack([target, 2.2 * target, 4.0 * target + 0.3])
    found = measures(Motions(floors, 1.1 * target, 1.25 * wave), H)

    assert found[0] == 0.0
    assert found[1:3] == pytest.approx([10.0, 10.0])  # 0.1 of t
    assert found[3:5] == pytest.approx([12.0, 12.0])  # 0.15 of 1.25
    assert found[5:7] == pytest.approx([12.0, 20.0])  # 0.3 of 2.5; the mean does not count
    assert found[7:9] == pytest.approx([12.0, 26.0])  # 0.3 of 2.5; 1.3 of 5


@pytest.mark.parametrize("late", [0, 1, 19, 49])
def test_the_lag_is_the_one_that_was_put_in(late):
    """Random motion, so that only one lag fits."""
    motion = np.random.default_rng(3).standard_normal(2000).cumsum()

    assert lag(motion[60 - late : -late or None][:1900] + 5.0, motion[60:][:1900]) == late


def test_a_lag_after_which_a_motion_is_at_rest_is_passed_over():
    motion = np.zeros(60)
    motion[:20] = np.random.default_rng(1).standard_normal(20)
    late = np.concatenate([np.zeros(3), motion[:-3]])

    assert lag(late, motion) == 3


def test_a_motion_that_is_early_has_no_negative_lag():
    motion = np.sin(0.01 * np.arange(2000))

    assert lag(motion[10:], motion[:-10]) == 0


@pytest.mark.parametrize("form", ["rows", "columns", "csv"])
def test_a_record_is_two_rows_or_two_columns_and_is_scaled(tmp_path, form):
    times, values = np.array([0.0, 0.02, 0.04, 0.1]), np.array([0.0, 1.0, -2.0, 1.0])
    if form == "csv":
        path = tmp_path / "quake.csv"
        lines = [f"{t},{a}" for t, a in zip(times, values, strict=True)]
        path.write_text("\n".join(["time,acceleration", *lines]), encoding="utf-8")
    else:
        path = tmp_path / "quake.mat"
        table = np.array([times, values])
        savemat(path, {"Accel": table if form == "rows" else table.T})
    record = read_record(path, 0.4)

    assert record.name == "quake"
    assert record.accelerations == pytest.approx(0.4 * values)
    assert record.n_ticks(0.01) == 10
    assert record.at_ticks(0.01)[:5] == pytest.approx([0.0, 0.2, 0.4, -0.2, -0.8])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("t,a,b\n0,1,2\n1,2,3\n2,1,1\n", "got 3 columns"),
        ("t,a\n0,1\n1,2\n1,3\n", "time of sample 2, got 1 s"),
        ("t,a\n0.5,1\n1,2\n", "time of sample 0, got 0.5 s"),
        ("t,a\n0,0\n1,0\n", "got 0 everywhere"),
    ],
)
def test_what_is_no_ground_motion_is_refused(tmp_path, text, said):
    path = tmp_path / "quake.csv"
    path.write_text(text, encoding="utf-8")

    with pytest.raises(DataError, match=said):
        read_record(path, 1.0)


def test_a_scale_that_is_no_number_is_refused(tmp_path):
    path = tmp_path / "quake.csv"
    path.write_text("t,a\n0,1\n1,2\n", encoding="utf-8")

    with pytest.raises(DataError, match="not finite with a scale of nan"):
        read_record(path, math.nan)


def test_perturbed_plants_are_the_same_each_time_and_spread_as_published():
    nominal = {"k_e": 1190e3, "b_1": 425.0, "b_2": 9.9976e4, "a_3": 3.3}
    plants = [perturbed(nominal, seed) for seed in range(1, 401)]

    assert perturbed(nominal, 7) == plants[6]
    for name, deviation in DEVIATIONS.items():
        drawn = [plant[name] for plant in plants]
        assert np.mean(drawn) == pytest.approx(nominal[name], abs=4.0 * deviation / math.sqrt(400))
        assert np.std(drawn) == pytest.approx(deviation, rel=0.15)
