"""What may be claimed, from what is left and what the sealed rows say."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from master.diagnosis.adequacy.channels import Adequacy, Kind, Predictor
from master.diagnosis.adequacy.slot_laws import SlotLaw
from master.diagnosis.answer.claims import Status, Verdict, claims, shape, verdict
from master.diagnosis.judge.stages import Stage
from master.diagnosis.numerics.folds import Share
from master.diagnosis.numerics.noise_floor import Colour, Evidence, NoiseFloor
from master.diagnosis.numerics.sealed_gain import SealedGain
from master.diagnosis.numerics.whiteness import Interval
from master.diagnosis.replay.placed_effect import PlacedEffect

SPRING = PlacedEffect("contact", "rope_force", "quadratic_stiffness")
FRICTION = PlacedEffect("contact", "guide_force", "coulomb")
IN_ROPE = SlotLaw("contact.rope_force", ("position",))
IN_GUIDE = SlotLaw("contact.guide_force", ("velocity",))


def channel(share=0.0, *, law=None, ratio=1.0, events=(), width=0.02):
    interval = Interval(share - width, share + width)
    kind = Kind.LINEAR if law is None else Kind.LAW
    predictor = Predictor(kind, str(law or ""), Share(share, interval), law)
    floor = NoiseFloor(0.5, Evidence.DIFFERENCES)
    return Adequacy("f", 0.5 * ratio, floor, 0.0, (predictor,), Colour(0.0, (), 0), events)


def part(effects=(), *, before=None, after=None, **changed):
    first = Stage("refit", (before or channel(0.8, ratio=8.0),))
    last = Stage("effects", (after or channel(),))
    given = {
        "name": "contact",
        "chosen": SimpleNamespace(effects=tuple(effects), parameters=()),
        "values": {},
        "unknown_numbers": {},
        "has_effect": bool(effects),
        "is_named": True,
        "is_exact": False,
        "is_judged": True,
        "families": [],
        "objections": {},
        "stages": (first, last) if effects else (first,),
        "final": last if effects else first,
        "software_fault": None,
        "parameter_gain": False,
    }
    return SimpleNamespace(**given | changed)


def sealed(*effects, low=0.5, confirmed=True, worse=False):
    gains = {str(e): SealedGain(0.6, Interval(low, 0.7)) for e in effects}
    return SimpleNamespace(gains=gains, is_confirmed=confirmed, is_refit_worse=worse)


def judged(own, rows):
    return verdict(SimpleNamespace(parts=(own,)), {"contact": rows})


def status(own, rows):
    return [c.status for c in claims(own, rows)]


def test_a_name_that_leaves_noise_is_traced():
    own = part([FRICTION])

    assert status(own, sealed(FRICTION)) == [Status.TRACED]
    assert judged(own, sealed(FRICTION)) is Verdict.TRACED


def test_a_name_whose_own_signals_predict_what_it_leaves_is_the_nearest_name():
    own = part([SPRING], after=channel(0.6, law=IN_ROPE, ratio=3.3))

    assert status(own, sealed(SPRING)) == [Status.NEAREST]
    assert judged(own, sealed(SPRING)) is Verdict.UNDECLARED


def test_a_name_with_a_remainder_in_another_place_is_partly():
    own = part([SPRING], after=channel(0.6, law=IN_GUIDE, ratio=3.3))

    assert status(own, sealed(SPRING)) == [Status.TRACED]
    assert judged(own, sealed(SPRING)) is Verdict.PARTLY


def test_a_name_that_leaves_what_is_no_noise_and_follows_nothing_is_the_nearest_name():
    """It is less even in time than noise; within the floor, or where it strikes at some times, it is not."""
    rest = replace(channel(0.01, ratio=1.9), chance=1e-7)
    own = part([FRICTION], after=rest)
    of_class = part([FRICTION], after=rest, families=[(str(FRICTION), "contact.guide_force: dahl")])
    noise = part([FRICTION], after=replace(rest, chance=0.01))
    elsewhere = part([FRICTION], after=replace(rest, strikes=(1.25, 7.5)))

    assert status(own, sealed(FRICTION)) == [Status.NEAREST]
    assert status(of_class, sealed(FRICTION)) == [Status.NEAREST]
    assert judged(own, sealed(FRICTION)) is Verdict.UNDECLARED
    assert "no noise: its size differs from time to time" in shape(rest)
    assert judged(noise, sealed(FRICTION)) is Verdict.TRACED
    assert judged(elsewhere, sealed(FRICTION)) is Verdict.PARTLY


@pytest.mark.parametrize("rows", [sealed(FRICTION, confirmed=False), sealed(FRICTION, low=-0.1)])
def test_what_the_sealed_rows_do_not_confirm_is_not_claimed(rows):
    assert judged(part([FRICTION]), rows) is Verdict.NOT_CONFIRMED


def test_an_effect_to_which_there_is_an_objection_is_never_traced():
    own = part([FRICTION], objections={str(FRICTION): "level is at a bound"})

    assert status(own, sealed(FRICTION)) == [Status.NEAREST]
    assert judged(own, sealed(FRICTION)) is Verdict.UNDECLARED


@pytest.mark.parametrize(
    ("unknown", "level", "expected"),
    [
        (("level", "length"), 4.0, Status.NEAREST),
        (("length",), 4.0, Status.TRACED),
        (("length",), 0.9, Status.NEAREST),
    ],
)
def test_an_effect_of_which_no_number_differs_from_zero_is_the_nearest_name(unknown, level, expected):
    """The level has a standard deviation of 0.5."""
    dahl = PlacedEffect("contact", "guide_force", "dahl")
    names = {n: dahl.variable(n) for n in ("level", "length")}
    own = part(
        [dahl],
        chosen=SimpleNamespace(effects=(dahl,), parameters=[SimpleNamespace(name=n) for n in names.values()]),
        unknown_numbers={names[n]: "it may be anything" for n in unknown},
        values={names["level"]: level, names["length"]: 1e-5},
        fit=SimpleNamespace(deviations={names["level"]: 0.5, names["length"]: 0.0}),
    )

    assert status(own, sealed(dahl)) == [expected]


@pytest.mark.parametrize(("left_at", "expected"), [(0.911, Status.NEAREST), (1.4, Status.TRACED)])
def test_a_law_that_swings_is_not_traced_where_what_is_left_swings_alike(left_at, expected):
    """At another frequency it is another cause's."""
    swing = PlacedEffect("contact", "rope_force", "parametric_stiffness")
    rest = channel(0.3, ratio=1.5)
    line = Predictor(Kind.MODULATED, "velocity", rest.share, None, left_at)
    own = part([swing], after=replace(rest, predictors=(line,)), values={swing.variable("frequency"): 0.9})

    assert status(own, sealed(swing)) == [expected]


def test_a_family_is_one_of_a_class():
    own = part([FRICTION], families=[(str(FRICTION), "contact.guide_force: dahl")])

    assert judged(own, sealed(FRICTION)) is Verdict.ONE_OF_A_CLASS


def test_two_effects_have_a_status_each():
    own = part([FRICTION, SPRING], families=[(str(SPRING), "contact.rope_force: cubic_stiffness")])

    assert status(own, sealed(FRICTION, SPRING)) == [Status.TRACED, Status.ONE_OF_A_CLASS]


def test_one_effect_that_is_not_confirmed_beside_one_that_is_leaves_a_remainder():
    both = part([FRICTION, SPRING])
    gains = {
        str(FRICTION): SealedGain(0.6, Interval(0.5, 0.7)),
        str(SPRING): SealedGain(0.0, Interval(-0.1, 0.1)),
    }
    rows = SimpleNamespace(gains=gains, is_confirmed=True, is_refit_worse=False)

    assert status(both, rows) == [Status.TRACED, Status.NOT_CONFIRMED]
    assert judged(both, rows) is Verdict.PARTLY


def test_without_a_name_what_is_predictable_is_undeclared():
    assert judged(part(), sealed()) is Verdict.UNDECLARED


def test_many_floors_that_nothing_predicts_are_said():
    loud = part(before=channel(0.0, ratio=9.0))
    rare = part(before=channel(0.0, ratio=2.0, events=(1.25, 7.5)))

    assert judged(loud, sealed()) is Verdict.UNEXPLAINED
    assert judged(rare, sealed()) is Verdict.UNEXPLAINED
    assert "intermittent, around t = 1.25, 7.50 s" in shape(rare.final.worst)


def test_what_is_set_off_and_rings_on_is_said_with_its_times():
    silent, predicted = (replace(channel(share, ratio=9.0), strikes=(1.25, 7.5)) for share in (0.0, 0.4))

    assert "it is intermittent: it is set off around t = 1.25, 7.50 s, and rings on" in shape(silent)
    assert shape(predicted).endswith("; it is set off around t = 1.25, 7.50 s")


@pytest.mark.parametrize(("gain", "expected"), [(True, Verdict.PARAMETERS), (False, Verdict.NOTHING)])
def test_nothing_is_missing_only_where_nothing_is_predictable(gain, expected):
    assert judged(part(before=channel(0.01), parameter_gain=gain), sealed()) is expected


def test_other_numbers_that_the_sealed_rows_refute_do_not_suffice():
    own = part(before=channel(0.01), parameter_gain=True)

    assert judged(own, sealed(worse=True)) is Verdict.NOTHING


def test_a_fault_of_software_is_the_verdict():
    assert judged(part(software_fault="late"), sealed()) is Verdict.SOFTWARE


@pytest.mark.parametrize(("ratio", "expected"), [(1.0, Verdict.NOTHING), (2.9, Verdict.UNDECLARED)])
def test_rounding_of_what_was_recorded_is_noise_within_the_floor(ratio, expected):
    """A converter of 12 bit repeats over the signals; what is more than its noise is a finding."""
    own = channel(0.15, ratio=ratio)
    rounded = replace(own.predictors[0], kind=Kind.PERIODIC)
    before = replace(own, predictors=(rounded,), has_steps=True)

    assert judged(part(before=before), sealed()) is expected
