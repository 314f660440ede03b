"""What a diagnosis will cost is said before it begins."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from master.cli import main
from master.diagnosis.case.case import read_case
from master.diagnosis.judge.checked import check_case
from master.diagnosis.judge.cost import REFERENCE, Cost, PartCost, _rounded
from master.diagnosis.judge.diagnose import diagnose

CASES = Path(__file__).parents[4] / "configs" / "measured"
PART = PartCost(
    name="axis",
    channels=2,
    rows=1000,
    recordings=1,
    steps=10_000,
    substeps=50_000,
    parameters=3,
    effects=4,
    built=3,
    missing_pairs=2.0,
    is_software=False,
)
REPLAY = 3.5e-3 + 10_000 * 0.3e-6 + 50_000 * 0.1e-6  # s: 11.5 ms
KNOWN = 4.5 + 2.3 + 2 * 0.8 + 80 * REPLAY + 1.5 + 0.2e-3 * 1000 * 2
PASS = REPLAY + 0.8e-6 * 1000 * 2
SCREENED = 4 * (0.02 + 9e-6 * 10_000)
TWO_ROUNDS = 2 * 4 * 15 * ((3 + 2) + (3 + 4)) * PASS + 2 * SCREENED
FOUR_ROUNDS = 2 * 4 * 15 * ((3 + 2) + (3 + 4) + (3 + 6) + (3 + 8)) * PASS + 4 * SCREENED


class BegunError(Exception):
    """Raised when the first part is replayed."""


def test_the_cost_of_a_part_is_that_of_its_replays_pictures_and_models():
    cost = Cost((PART,), 1.0)

    assert cost.low == pytest.approx(KNOWN)
    assert cost.seconds == pytest.approx(KNOWN + 9.0 + TWO_ROUNDS + 2.0 * (3 + 2))
    assert cost.high == pytest.approx(KNOWN + 9.0 + FOUR_ROUNDS + 4.0 * (3 + 2))


@pytest.mark.parametrize(("seconds", "said"), [(99.4, "99 s"), (99.6, "1.7 min"), (8.04, "8 s")])
def test_times_are_said_in_two_digits_without_powers_of_ten(seconds, said):
    assert _rounded(seconds) == said


def test_a_machine_of_twice_the_speed_takes_half_the_time():
    assert Cost((PART,), 2.0).seconds == pytest.approx(0.5 * Cost((PART,), 1.0).seconds)


def test_of_several_parts_one_is_searched_and_all_are_judged():
    alone = Cost((PART,), 1.0)
    both = Cost((PART, replace(PART, effects=2, built=0, missing_pairs=0.0)), 1.0)

    assert both.seconds - alone.seconds == pytest.approx(KNOWN - 4.5 - 2.3)


def test_check_says_it_as_text_and_as_data(monkeypatch):
    monkeypatch.setattr("master.diagnosis.judge.cost.speed_probe", lambda: REFERENCE)
    case = CASES / "first_case.yaml"
    found = json.loads(CliRunner().invoke(main, ["check", str(case), "--json"]).stdout)["cost"]
    text = CliRunner().invoke(main, ["check", str(case)]).stdout

    assert 5.0 < found["low"] < found["seconds"] < found["high"]
    (part,) = found["parts"]
    assert (part["effects"], part["steps"], part["substeps"], part["parameters"]) == (3, 4000, 0, 2)
    assert "a diagnosis takes about " in text
    assert "3 effects in 1 part, 4000 steps and 0 substeps a replay" in text


def test_a_model_that_is_in_no_cache_has_to_be_built(tmp_path, monkeypatch):
    monkeypatch.setattr("master.diagnosis.judge.cost.cache_folder", lambda: tmp_path)
    part = check_case(CASES / "first_case.yaml").cost.parts[0]
    names = ["servo_axis_inverse__friction_coulomb", "servo_axis_inverse__friction_quadratic_damping"]
    for name in names:
        (tmp_path / "fmus" / "native" / name).mkdir(parents=True)
        (tmp_path / "fmus" / "native" / name / f"{name}.fmu").touch()

    assert part.built == 3
    assert check_case(CASES / "first_case.yaml").cost.parts[0].built == 1


def test_a_cache_that_cannot_be_read_counts_as_empty(monkeypatch):
    def refuse(folder):
        raise PermissionError(13, "Permission denied", folder)

    monkeypatch.setattr("master.diagnosis.judge.cost.os.scandir", refuse)

    assert check_case(CASES / "first_case.yaml").cost.parts[0].built == 3


def test_a_diagnosis_that_nobody_asks_does_not_foretell_its_cost(monkeypatch):
    asked = []
    monkeypatch.setattr("master.diagnosis.judge.diagnose.cost_of", lambda *given: asked.append(given))

    def progress(text):
        if "replay" in text:
            raise BegunError

    with pytest.raises(BegunError):
        diagnose(read_case(CASES / "first_case.yaml"), progress)

    assert asked == []


def test_a_diagnosis_says_it_once_before_anything_is_replayed():
    told = []

    def progress(text):
        if "replay" in text:
            raise BegunError

    with pytest.raises(BegunError):
        diagnose(read_case(CASES / "first_case.yaml"), progress, announce=told.append)

    assert len(told) == 1
    assert told[0].startswith("a diagnosis takes about ")
