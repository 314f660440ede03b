"""What a diagnosis will cost is said before it begins."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from master.cli import main
from master.diagnosis.case.case import read_case
from master.diagnosis.judge.cost import REFERENCE, Cost, PartCost, _missing, _rounded
from master.diagnosis.judge.diagnose import diagnose

EFFECTS = ("coulomb", "quadratic_damping", "cubic_stiffness")
CASES = Path(__file__).parents[4] / "configs" / "measured"
PART = PartCost(
    name="axis",
    channels=2,
    rows=1000,
    recordings=1,
    steps=10_000,
    substeps=50_000,
    substeps_of_memory=20_000,
    parameters=3,
    effects=4,
    missing=0.5,
    is_software=False,
)
REPLAY = 0.8e-3 + 10_000 * 0.21e-6 + 50_000 * 0.07e-6  # s: 6.4 ms
JUDGED = 0.8 + 0.1e-3 * 1000 * 2
KNOWN = 3.5 + 1.4 + 2 * 0.45 + 80 * REPLAY + JUDGED
FIRST = 4 * 28 * (3 + 2) * (REPLAY + 0.05e-6 * 1000 * 2)
LATER = 4 * 28 * 1.5 * (REPLAY + 0.05e-6 * 1000 * 2 + 0.5 * 20_000 * 0.07e-6)  # of each parameter
SCREENED = 4 * (0.01 + 4e-6 * 10_000)
BUILT = 1.8 * 0.5 * 4  # s a round: half of four models
TWO_ROUNDS = JUDGED + FIRST + LATER * (3 + 4) + 2 * (SCREENED + BUILT)
FOUR_ROUNDS = JUDGED + FIRST + LATER * ((3 + 4) + (3 + 6) + (3 + 8)) + 4 * (SCREENED + BUILT)


class BegunError(Exception):
    """Raised when the first part is replayed."""


def test_the_cost_of_a_part_is_that_of_its_replays_pictures_and_models():
    cost = Cost((PART,), 1.0)

    assert cost.low == pytest.approx(KNOWN)
    assert cost.seconds == pytest.approx(KNOWN + 9.0 + TWO_ROUNDS)
    assert cost.high == pytest.approx(KNOWN + 9.0 + FOUR_ROUNDS)


@pytest.mark.parametrize(("seconds", "said"), [(99.4, "99 s"), (99.6, "1.7 min"), (8.04, "8 s")])
def test_times_are_said_in_two_digits_without_powers_of_ten(seconds, said):
    assert _rounded(seconds) == said


def test_a_machine_of_twice_the_speed_takes_half_the_time():
    assert Cost((PART,), 2.0).seconds == pytest.approx(0.5 * Cost((PART,), 1.0).seconds)


def test_of_several_parts_one_is_searched_and_all_are_judged():
    alone = Cost((PART,), 1.0)
    both = Cost((PART, replace(PART, effects=2, missing=0.0)), 1.0)

    assert both.seconds - alone.seconds == pytest.approx(KNOWN - 3.5 - 1.4)


def test_check_says_it_as_text_and_as_data(monkeypatch):
    monkeypatch.setattr("master.diagnosis.judge.cost.speed_probe", lambda: REFERENCE)
    case = CASES / "first_case.yaml"
    found = json.loads(CliRunner().invoke(main, ["check", str(case), "--json"]).stdout)["cost"]
    text = CliRunner().invoke(main, ["check", str(case)]).stdout

    assert 4.0 < found["low"] < found["seconds"] < found["high"]
    (part,) = found["parts"]
    assert (part["effects"], part["steps"], part["substeps"], part["parameters"]) == (3, 4000, 0, 2)
    assert "a diagnosis takes about " in text
    assert "3 effects in 1 part, 4000 steps and 0 substeps a replay" in text


class Target:
    """A model that is current in the cache, or not."""

    def __init__(self, name, current):
        self.name = name
        self.current = current

    def is_current(self):
        return self.name in self.current


@pytest.mark.parametrize(
    ("current", "missing"),
    [([], 1.0), (["coulomb"], 2 / 3), (["coulomb", "quadratic_damping", "cubic_stiffness"], 0.0)],
)
def test_models_that_are_not_current_in_the_cache_have_to_be_built(current, missing, monkeypatch):
    names = {f"servo_axis_inverse__friction_{effect}" for effect in current}
    monkeypatch.setattr("master.diagnosis.judge.cost.build.target", lambda name: Target(name, names))

    assert _missing([f"servo_axis_inverse__friction_{e}" for e in EFFECTS]) == pytest.approx(missing)


def test_of_many_models_as_many_as_are_fitted_are_enough(monkeypatch):
    current = {f"m{i}" for i in range(0, 40, 4)}
    asked = []

    def target(name):
        asked.append(name)
        return Target(name, current)

    monkeypatch.setattr("master.diagnosis.judge.cost.build.target", target)

    assert _missing([f"m{i}" for i in range(40)]) == 0.0
    assert len(asked) == 10


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
