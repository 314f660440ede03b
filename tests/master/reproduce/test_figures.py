"""The figures as data: which there are, what they need, and how curves are thinned out."""

from __future__ import annotations

import numpy as np
import pytest

from master.reproduce.figures.plot import CROSS, DASHED, REFERENCE, Curve, Panel, as_data, colours, decimated
from master.reproduce.figures.registry import FIGURES, PAPER


def test_every_figure_of_results_is_there():
    assert [f.id for f in PAPER] == [str(n) for n in (*range(10, 23), *range(24, 29))]


@pytest.mark.parametrize("figure", FIGURES, ids=lambda f: f.id)
def test_a_caption_says_what_the_paper_shows_and_what_ours_shows(figure):
    assert figure.title
    assert figure.paper
    assert figure.ours


def test_thinning_keeps_ends_and_extremes():
    x = np.linspace(0.0, 10.0, 10001)
    y = np.sin(x)
    y[5000] = 7.0
    thin = decimated(Curve("y", x, y), columns=50)

    assert len(thin.x) <= 102
    assert (thin.x[0], thin.x[-1]) == (0.0, 10.0)
    assert (max(thin.y), min(thin.y)) == (7.0, min(y))
    assert all(np.diff(thin.x) > 0.0)


def test_marks_are_never_thinned():
    marks = Curve("poles", np.arange(5000.0), np.zeros(5000), CROSS)

    assert decimated(marks, columns=10) is marks


def test_the_reference_is_grey_and_takes_no_colour():
    t = np.zeros(2)
    panel = Panel("", "", "", [Curve("ideal", t, t, REFERENCE), Curve("a", t, t), Curve("b", t, t)])

    assert colours(panel) == ["#9a9a9a", "#0b6fb8", "#d1495b"]


def test_a_theory_has_the_colour_of_what_it_is_the_theory_of():
    t = np.zeros(2)
    theory = [Curve(f"{n}, theory", t, t, DASHED, like=n) for n in "ab"]
    panel = Panel("", "", "", [Curve("a", t, t), Curve("b", t, t), *theory])

    assert colours(panel) == ["#0b6fb8", "#d1495b"] * 2


def test_values_that_are_not_finite_are_left_out():
    panel = Panel("", "time [s]", "force [N]", [Curve("f", np.arange(3.0), np.array([1.0, np.inf, 2.0]))])

    [curve] = as_data(panel)["curves"]
    assert (curve["x"], curve["y"]) == ([0.0, 2.0], [1.0, 2.0])
