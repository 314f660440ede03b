"""How claims are judged: worst seed, bounds, verdicts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from master.reproduce.claims.claim import (
    CONDITION,
    FAILS,
    HOLDS,
    SEEDS,
    Bound,
    Check,
    Claim,
    above,
    around,
    below,
    changed_verdicts,
    judge,
    overall,
    wishes,
)
from master.reproduce.facts.cases import KNOWN
from master.reproduce.measures.measures import MEANINGS, MEASURES
from master.reproduce.measures.runs import Recording, Run
from master.reproduce.reproduction import CLAIMS

RUN = Run("system", "none")


def claim(check: Check, if_met: str = HOLDS) -> Claim:
    return Claim("stable", "Sec. I", "It is stable", "because", (check,), if_met, "a formula")


def recordings(values):
    time = np.zeros(0)
    return {
        RUN.with_seed(seed): Recording("completed", {"zeta": value}, time)
        for seed, value in zip(SEEDS, values, strict=True)
    }


def judged(bound: Bound, values, if_met: str = HOLDS):
    check = Check("one", "a case", "zeta", (RUN,), bound)
    [row] = judge(claim(check, if_met), recordings(values))
    return row


def test_the_worst_of_ten_seeds_counts():
    row = judged(above(1.0), [2.0] * 9 + [1.5])

    assert (row.measured, row.seeds, row.verdict) == (1.5, 10, HOLDS)


def test_one_seed_outside_the_bound_is_enough_to_fail():
    assert judged(below(1.0), [0.5] * 9 + [1.5]).verdict == FAILS


def test_a_run_without_the_number_fails():
    row = judged(below(1.0), [0.5] * 9 + [math.nan])

    assert (row.measured, row.verdict) == (None, FAILS)


def test_a_condition_is_the_verdict_of_a_met_bound():
    assert judged(around(0.0, 1.0), [0.5] * 10, CONDITION).verdict == CONDITION


def test_a_row_says_what_is_measured_and_its_bound():
    row = judged(around(-1.0, 0.5), [-1.0] * 10)

    assert row.as_dict() == {
        "id": "stable.one",
        "place": "Sec. I",
        "claim": "It is stable (a case)",
        "bound": "-1.5 < zeta < -0.5",
        "bound_from": "a formula",
        "measured": -1.0,
        "seeds": 10,
        "noise": "worst of 10 seeds",
        "verdict": HOLDS,
        "why": "because",
    }


def test_a_bound_around_zero_is_one_of_the_magnitude():
    assert around(0.0, 1.5).text("phase", "deg") == "|phase| < 1.5 deg"


def test_numbers_of_several_runs_make_one():
    other = Run("system", "cfdc")
    check = Check("one", "a case", "zeta", (RUN, other), below(1.0), combine=lambda a, b: a / b)
    found = recordings([1.0] * 10)
    found |= {
        other.with_seed(run.seed): Recording("completed", {"zeta": 4.0}, r.time) for run, r in found.items()
    }

    assert judge(claim(check), found)[0].measured == 0.25


def test_a_verdict_that_is_not_the_one_of_old_is_named():
    check = Check("one", "a case", "zeta", (RUN,), below(1.0), expected=FAILS)
    one = claim(check)

    assert changed_verdicts(one, judge(one, recordings([1.5] * 10))) == []
    assert changed_verdicts(one, judge(one, recordings([0.5] * 10))) == [
        f"stable.one: {HOLDS}, expected {FAILS}"
    ]


def test_every_seed_of_every_run_is_wished_for():
    wanted = wishes([claim(Check("one", "a case", "zeta", (RUN,), below(1.0)))])

    assert sorted(run.seed for run in wanted) == list(range(1, 11))
    assert {w.measures for w in wanted.values()} == {frozenset({"zeta"})}


def test_a_claim_whose_rows_differ_holds_with_a_condition():
    rows = [judged(above(1.0), [2.0] * 10), judged(above(1.0), [0.0] * 10)]

    assert overall(rows) == CONDITION
    assert overall(rows[:1]) == HOLDS


@pytest.mark.parametrize("one", CLAIMS, ids=lambda c: c.id)
def test_the_rows_of_the_paper_are_complete(one):
    assert one.place
    assert one.why
    for check in one.checks:
        assert check.measure in MEASURES
        assert check.measure in MEANINGS
        assert check.bound_from or one.bound_from
        assert check.expected in (None, HOLDS, CONDITION, FAILS)
        assert (check.expected != FAILS) or check.why or one.why


def test_a_check_has_its_own_source_of_the_bound_before_that_of_the_claim():
    check = Check("one", "a case", "fastest_pole", (RUN,), below(0.0), bound_from="another")
    found = {
        run: Recording("completed", {"fastest_pole": -1.0}, r.time)
        for run, r in recordings([0.0] * 10).items()
    }
    [row] = judge(claim(check), found)

    assert row.bound_from == "another"
    assert row.noise.startswith("no noise")


def test_what_is_known_without_a_run_is_what_the_formulas_give():
    """By hand: E2 -10.94 - atan(5.4972 * 0.01) = -14.09 deg; S2 2 * 0.00822/(0.912 sin 30.70) = 0.0353."""
    assert KNOWN["E2"].phase_of_force("hexapod", 0.01) == pytest.approx(-14.087, abs=1e-3)
    assert KNOWN["S2"].gain_error("hexapod", 0.00822) == pytest.approx(0.03531, abs=1e-5)


def test_no_row_stands_twice():
    ids = [f"{c.id}.{check.id}" for c in CLAIMS for check in c.checks]

    assert sorted(ids) == sorted(set(ids))
