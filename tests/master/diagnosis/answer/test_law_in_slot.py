"""What is drawn of a named law: its curve and band, and what was measured in its slot."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from master.diagnosis.answer.report.law_in_slot import HIDDEN, WINDOWED, WITH_MEMORY, bins, law_in_slot
from master.diagnosis.answer.report.named_law import law_charts, law_figure, law_text
from master.diagnosis.answer.report.page import page
from master.diagnosis.answer.report.panels import Panel
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.numerics.step_answers import convolved
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.injection import Injection
from tests.master.diagnosis.answer.made_up_report import UNITS, made_up_report

PERIOD = 1e-3
N = 6000
T = PERIOD * np.arange(N)
V = 0.06 * np.cos(3.0 * T) * np.cos(0.7 * T)
X = np.cumsum(V) * PERIOD
FORCE = 400.0 * X
AT_ONCE = np.ones((N, 1))
LAG = (1.0 - np.exp(-T / 0.03))[:, None]  # of first order, 30 ms
LEVEL, SMOOTHING, DAMPING = 3.0, 0.004, 20.0


@pytest.fixture
def part_of(study_of, monkeypatch):
    """Make a part of one output that answers to the slot by a step response, with a law and a truth there."""
    monkeypatch.setattr(Injection, "_is_same_at_all_times", lambda *_: True)  # it is made so

    def make(placed, values, *, left=0.0, step=AT_ONCE, deviations=None, states=None, is_windowed=False):
        measured = convolved(step[:, 0], np.asarray(left + 0.0 * T)[:, None])
        bench = SimpleNamespace(
            name="part",
            measured=measured,
            is_windowed=is_windowed,
            recordings={"run": np.zeros(N)},
            first_sample=lambda name: 0,
            times=T,
            record=lambda player, values: states or {},
            compared=lambda outputs: outputs,
            compared_rows=lambda signal: signal,
        )
        slot = SimpleNamespace(unit="N", signals={"q": "m", "der_q": "m/s"}, position=None)
        system = SimpleNamespace(values={}, slots=lambda fmu: {"rope": slot})
        pool = SimpleNamespace(build=lambda models, progress: None, player_with_states=lambda effects: None)
        study = study_of(measured, [], bench=bench, system=system, pool=pool)
        signals = {"value": FORCE, "position": X, "velocity": V}
        own = {
            "slot_signals_with": lambda model, values, place: signals,
            "values_with": lambda values: values,
            "signal_rms": lambda place: SimpleNamespace(value=1.0),
            "outputs": lambda effects, values: {
                "run": step * sum(v for k, v in values.items() if k.endswith("rope_offset_offset"))
            },
        }
        study.__dict__.update(own)
        named = {placed.variable(name): value for name, value in values.items()}
        known = {placed.variable(name): value for name, value in (deviations or {}).items()}
        fit = Fit("x", named, known, np.zeros((N, 1)), 0.0)
        return SimpleNamespace(study=study, chosen=ExtendedModel((placed,)), fit=fit, values=named)

    return make


COULOMB = PlacedEffect("box", "rope", "coulomb")
VALUES = {"level": LEVEL, "smoothing": SMOOTHING}


@pytest.mark.parametrize("step", [AT_ONCE, LAG], ids=["at once", "lag"])
def test_the_points_are_the_force_that_was_there_and_not_the_law(part_of, step):
    """The slot held Coulomb friction and a damper, the law is Coulomb friction alone."""
    law = law_in_slot(part_of(COULOMB, VALUES, left=DAMPING * V, step=step), COULOMB)

    [over] = law.over
    true = LEVEL * np.tanh(over.measured.x / SMOOTHING) + DAMPING * over.measured.x
    slow = np.abs(over.measured.x) < 3.0 * SMOOTHING  # the law bends within a bin
    assert over.role == "velocity"
    assert over.measured.n_unresolved == 0
    assert over.measured.y[~slow] == pytest.approx(
        true[~slow], abs=0.05 * LEVEL
    )  # of 1.2 N that the law lacks
    assert np.sum(~slow) >= 10
    assert not law.why_no_points


def test_single_rows_are_drawn_where_the_outputs_answer_at_once(part_of):
    at_once = law_in_slot(part_of(COULOMB, VALUES, left=DAMPING * V), COULOMB).over[0].measured
    later = law_in_slot(part_of(COULOMB, VALUES, left=DAMPING * V, step=LAG), COULOMB).over[0].measured

    assert at_once.cloud_y == pytest.approx(LEVEL * np.tanh(V / SMOOTHING) + DAMPING * V, abs=1e-9)
    assert len(later.cloud_y) == 0


def test_the_band_is_two_deviations_of_the_parameters(part_of):
    """By hand: the law is in proportion to its level."""
    law = law_in_slot(part_of(COULOMB, VALUES, deviations={"level": 0.2}), COULOMB)

    curve = law.over[0].curve
    assert curve.high - curve.y == pytest.approx(2.0 * 0.2 * np.abs(np.tanh(curve.x / SMOOTHING)), abs=1e-9)
    assert curve.y - curve.low == pytest.approx(curve.high - curve.y, abs=1e-9)


def test_parameters_that_only_trade_against_each_other_make_no_band(part_of):
    """By hand: where 0.5 N more of friction are 10 N s/m less of damping, the force at 0.05 m/s is known."""
    friction = PlacedEffect("box", "rope", "asymmetric_friction")
    values = {"forward": 3.0, "backward": 3.0, "damping_difference": 10.0, "smoothing": 1e-4}
    part = part_of(friction, values, deviations={"forward": 0.5, "damping_difference": 10.0})
    bound = {("forward", "forward"): 0.25, ("damping_difference", "damping_difference"): 100.0}
    bound |= {("forward", "damping_difference"): -5.0, ("damping_difference", "forward"): -5.0}
    covariance = np.array([[bound.get((one, other), 0.0) for other in values] for one in values])
    part.fit = replace(part.fit, covariance=covariance)

    curve = law_in_slot(part, friction).over[0].curve

    at = np.argmin(np.abs(curve.x - 0.05))
    assert curve.high[at] - curve.y[at] == pytest.approx(0.0, abs=0.02)
    assert curve.high[-1] - curve.y[-1] == pytest.approx(2.0 * abs(0.5 - 10.0 * curve.x[-1]), rel=1e-3)


def test_a_law_of_nothing_is_drawn_over_time(part_of):
    offset = PlacedEffect("box", "rope", "offset")

    [over] = law_in_slot(part_of(offset, {"offset": 2.0}), offset).over
    assert over.role == "time"
    assert over.curve.y == pytest.approx(2.0)


def test_a_law_with_memory_is_a_loop_of_its_own_states(part_of):
    """By hand: Dahl's law adds its level times the share that has built up."""
    dahl = PlacedEffect("box", "rope", "dahl")
    share = np.tanh(np.sin(T))
    part = part_of(dahl, {"level": 4.0, "length": 1e-3}, states={dahl.variable("share"): share}, step=LAG)

    law = law_in_slot(part, dahl)

    assert [over.role for over in law.over] == ["position", "velocity"]
    assert [over.curve for over in law.over] == [None, None]
    assert law.added == pytest.approx(4.0 * share)
    assert law.why_no_points == WITH_MEMORY
    assert WITH_MEMORY in law_text(law)
    assert law_charts(part, law) == []


def test_where_nothing_honest_can_be_drawn_the_report_says_why(part_of):
    dahl = PlacedEffect("box", "rope", "dahl")

    hidden = law_in_slot(part_of(dahl, {"level": 4.0, "length": 1e-3}), dahl)
    windowed = law_in_slot(part_of(COULOMB, VALUES, is_windowed=True), COULOMB)

    assert law_text(hidden) == f"No picture of this law: {HIDDEN}."
    assert windowed.over[0].curve is not None
    assert windowed.over[0].measured is None
    assert law_text(windowed).endswith(f"Nothing measured is drawn with it: {WINDOWED}.")


def test_bins_have_enough_samples_and_width():
    signal = np.concatenate([np.zeros(5000), np.linspace(-1.0, 1.0, 1000) ** 3])

    number = bins(signal)

    assert np.bincount(number).min() >= 10
    assert number.max() >= 10


def test_a_drawn_law_has_its_units_and_is_shown_with_its_equation(part_of, tmp_path):
    part = part_of(COULOMB, VALUES, left=DAMPING * V)
    law = law_in_slot(part, COULOMB)
    [chart] = law_charts(part, law)
    (ax,) = law_figure(part, law).axes

    assert (chart.x_label, chart.y_label) == ("velocity [m/s]", "added to rope [N]")
    bars, circles = chart.curves[1:]
    assert 0.5 * (bars.y[0::3] + bars.y[1::3]) == pytest.approx(circles.y)
    assert np.isnan(bars.y[2::3]).all()
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("velocity [m/s]", "added to rope [N]")

    (tmp_path / "law.png").write_bytes(b"picture")
    name = "axis.friction: coulomb"
    drawn = page(made_up_report(), [Panel("axis", tmp_path / "law.png", "Below it.", [chart], name)], UNITS)
    refused = page(made_up_report(), [Panel("axis", None, "No picture: why.", law=name)], UNITS)
    for text, shown in ((drawn, "Below it."), (refused, "<p>No picture: why.</p>")):
        assert (
            text.index("F_c tanh")
            < text.index(shown)
            < text.index("What is left, and what still predicts it")
        )
