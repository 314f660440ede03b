"""Runs against a reference: every difference is found, and nothing that cannot be compared is left out."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner

from master.cli import main
from master.recording.files import write_result
from master.recording.recorder import Result

TIME = 0.5 * np.arange(5)
H = np.array([1.0, 2.0, 4.0, 8.0, 16.0])


def written(folder, **signals):
    names = tuple(name.replace("_", ".", 1) for name in signals)
    result = Result(TIME, names, ("m",) * len(names), np.column_stack(list(signals.values())))
    write_result(result, folder)
    return folder


def csv(path, text):
    path.write_text(text, encoding="utf-8")
    return path


def table(time, **columns):
    rows = [",".join(["time", *(name.replace("_", ".", 1) for name in columns)])]
    rows += [",".join(map(repr, map(float, row))) for row in zip(time, *columns.values(), strict=True)]
    return "\n".join(rows) + "\n"


def compare(*words):
    done = CliRunner().invoke(main, ["compare", *map(str, words)])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done


def answer(*words):
    done = compare(*words, "--json")
    [found] = json.loads(done.stdout)["comparisons"]
    return done.exit_code, found


@pytest.fixture
def first(tmp_path):
    return written(tmp_path / "first", ball_h=H, ball_v=-H)


def test_equal_bits_in_folder_and_csv_have_status_0(first):
    code, found = answer(first, first / "result.csv")

    assert (code, found["within"], found["rows"], found["faults"]) == (0, True, 5, [])
    assert [s["unequal"] for s in found["signals"]] == [0, 0]


def test_a_difference_is_measured_by_hand(first, tmp_path):
    other = written(tmp_path / "other", ball_h=H + np.array([0.0, 0.0, 3.0, 0.0, -4.0]), ball_v=-H)
    code, found = answer(first, other)
    h, v = found["signals"]

    assert (code, v["within"]) == (1, True)
    assert (h["max_abs"], h["max_at"], h["first_beyond"], h["beyond"]) == (4.0, 2.0, 1.0, 2)
    assert h["rms"] == pytest.approx(math.sqrt((9.0 + 16.0) / 5.0), rel=1e-15)


def test_the_last_bit_is_a_difference_without_a_tolerance_and_none_with_one(first, tmp_path):
    other = written(tmp_path / "other", ball_h=np.nextafter(H, 100.0), ball_v=-H)

    assert answer(first, other)[0] == 1
    assert answer(first, other, "--tolerance", "1e-12")[0] == 0


@pytest.mark.parametrize(
    ("tolerance", "code"),
    [("0.1", 0), ("0.09", 1), ("1%", 0), ("0.5%", 1), ("ball.h=0.1", 0), ("ball.v=0.1", 1)],
)
def test_a_tolerance_is_absolute_or_a_share_of_the_largest_magnitude(first, tmp_path, tolerance, code):
    other = written(tmp_path / "other", ball_h=H + np.array([0.09999, 0.0, 0.0, 0.0, 0.0]), ball_v=-H)

    assert answer(first, other, "--tolerance", tolerance)[0] == code


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_zeros_of_two_signs_are_not_equal_bits(tmp_path, sign):
    one = written(tmp_path / "one", a_x=np.zeros(5))
    other = written(tmp_path / "other", a_x=sign * np.zeros(5))

    assert answer(one, other)[0] == (0 if sign > 0 else 1)


def test_what_is_no_number_in_one_run_is_beyond_any_tolerance(first, tmp_path):
    broken = np.array([1.0, math.nan, 4.0, math.inf, 16.0])
    other = written(tmp_path / "other", ball_h=broken, ball_v=-H)
    code, found = answer(first, other, "--tolerance", "1e9")

    assert (code, found["signals"][0]["no_numbers"], found["signals"][0]["max_abs"]) == (1, 2, 0.0)
    assert found["faults"][0].startswith("ball.h: not a number or infinite in one of the runs in 2 of 5 rows")


def test_the_same_nan_and_infinity_in_both_are_equal(tmp_path):
    broken = np.array([1.0, math.nan, -math.inf, math.inf, 16.0])
    one, other = (written(tmp_path / name, a_x=broken) for name in ("one", "other"))

    assert answer(one, other)[0] == 0


def test_a_signal_that_one_run_lacks_is_a_difference_and_said_with_common(first, tmp_path):
    other = written(tmp_path / "other", ball_h=H, ball_w=H)
    code, found = answer(first, other, "--tolerance", "1")

    assert code == 1
    assert found["faults"] == [f"ball.v: only in {first}", f"ball.w: only in {other}"]
    done = compare(first, other, "--common")
    assert done.exit_code == 0
    assert f"note: ball.v: only in {first}" in done.stdout
    assert compare(first, other, "--signal", "ball.h").exit_code == 0


def test_rows_at_other_times_are_differences_and_said_with_common(first, tmp_path):
    sparse = csv(
        tmp_path / "sparse.csv", table([0.0, 1.0, 7.0], ball_h=[1.0, 4.0, 0.0], ball_v=[-1.0, -4.0, 0.0])
    )
    code, found = answer(first, sparse)

    assert (code, found["rows"]) == (1, 2)
    assert (found["rows_only_in_reference"], found["rows_only_in_other"]) == (3, 1)
    assert answer(first, sparse, "--common")[0] == 0


def test_times_that_differ_by_rounding_belong_together(first, tmp_path):
    other = csv(tmp_path / "t.csv", table(TIME * (1.0 + 1e-15), ball_h=H, ball_v=-H))

    assert answer(first, other, "--tolerance", "0")[0] == 0
    code, found = answer(first, other)
    assert (code, found["rows"]) == (1, 5)
    assert found["faults"][0].startswith("times differ by up to ")


def test_names_of_a_tool_without_instances_are_taken_for_the_only_signal_that_ends_so(first, tmp_path):
    other = csv(tmp_path / "fmpy.csv", table(TIME, h=H, v=-H))
    done = compare(first, other)

    assert done.exit_code == 0
    assert f"note: h of {other} is taken for ball.h" in done.stdout
    two = written(tmp_path / "two", ball_h=H, cat_h=H, ball_v=-H)
    assert answer(two, other, "--common")[1]["signals_only_in_other"] == ["h"]


def test_units_that_differ_are_a_difference(first, tmp_path):
    result = Result(TIME, ("ball.h", "ball.v"), ("mm", "m"), np.column_stack([H, -H]))
    write_result(result, tmp_path / "mm")
    code, found = answer(first, tmp_path / "mm", "--tolerance", "1")

    assert (code, found["faults"]) == (1, ["ball.h: unit, got mm, expected m"])


def test_several_runs_are_each_compared_with_the_first(first, tmp_path):
    other = written(tmp_path / "other", ball_h=H + 1.0, ball_v=-H)
    done = compare(first, first / "result.csv", other, "--json")

    assert done.exit_code == 1
    assert [c["within"] for c in json.loads(done.stdout)["comparisons"]] == [True, False]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a,b\n1,2\n", "no column of times, got a, b, expected one of time, t"),
        ("time,ball.h\n", "no rows, expected one at least"),
        ("time,ball.h\n0,one\n", "row 2, column 'ball.h': got 'one', expected a number"),
        ("time,ball.h\n0,1\nnan,2\n", "row 3: time, got nan, expected a number"),
        ("time,ball.h\n1,1\n0,2\n", "row 3: time, got 0 s, expected at least 1 as in the row before"),
        ("time,x\n0,1\n", "no signal in common with"),
        ("time,ball.h\n0.3,1\n", "no time in common, got 0.3 to 0.3 s"),
    ],
)
def test_what_cannot_be_compared_has_status_2(first, tmp_path, text, said):
    done = compare(first, csv(tmp_path / "wrong.csv", text))

    assert done.exit_code == 2
    assert said in done.stderr


def test_faults_of_the_request_are_told_at_once(first):
    done = compare(first, "--tolerance", "small", "--tolerance", "-1", "--output", "x.pdf")

    assert done.exit_code == 2
    assert len(done.stderr.splitlines()) == 4
    done = compare(first, first, "--signal", "ball.hh", "--tolerance", "bal.v=1")
    assert done.exit_code == 2
    assert "expected 'ball.h'" in done.stderr
    assert "expected 'ball.v'" in done.stderr
    assert compare(first, first.parent / "nothing.csv").exit_code == 2


@pytest.mark.parametrize("name", ["overlay.html", "overlay.png"])
def test_the_runs_are_drawn_over_each_other(first, tmp_path, name):
    other = written(tmp_path / "other", ball_h=H + 1.0, ball_v=-H)
    done = compare(first, other, "--output", tmp_path / name)

    assert done.exit_code == 1
    content = (tmp_path / name).read_bytes()
    if name.endswith("html"):
        assert b"difference of ball.h" in content
        assert b"difference of ball.v" not in content
    else:
        assert content.startswith(b"\x89PNG")


def test_the_rows_of_a_run_that_was_killed_are_those_of_its_parts_not_of_a_cut_csv(tmp_path):
    whole = written(tmp_path / "whole", a_h=H)
    killed = tmp_path / "killed"
    for first, after in ((0, 2), (2, 5)):
        part = written(tmp_path / "part", a_h=H)
        result = Result(TIME[first:after], ("a.h",), ("m",), H[first:after, None])
        write_result(result, part)
        killed.mkdir(exist_ok=True)
        (part / "result.parquet").rename(killed / f"result.part-0000{1 + (first > 0)}.parquet")
    (killed / "result.csv").write_text('"time","a.h"\n0,1\n0.5,2\n1,4\n1.5,8\n2,1')  # of 16

    assert compare(whole, killed).exit_code == 0
