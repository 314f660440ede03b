"""Colours that people who do not see green tell apart, and that are seen on their page."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from master.pages import palette
from master.pages.palette import (
    DARK,
    DARK_PAGE,
    DARK_REFERENCE,
    LIGHT,
    LIGHT_PAGE,
    LIGHT_REFERENCE,
    look,
)
from tests.master.pages.sight import DEUTERANOPIA, contrast, distance, lab, linear


def test_the_measures_agree_with_known_values():
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert lab(linear("#ff0000")) == pytest.approx([53.24, 80.09, 67.20], abs=0.05)


@pytest.mark.parametrize(
    "colours", [(*LIGHT, LIGHT_REFERENCE), (*DARK, DARK_REFERENCE)], ids=["light", "dark"]
)
@pytest.mark.parametrize("sight", [np.eye(3), DEUTERANOPIA], ids=["all cones", "no green"])
def test_any_two_colours_are_told_apart(colours, sight):
    distances = {(a, b): distance(a, b, sight) for a, b in itertools.combinations(colours, 2)}

    assert {pair: d for pair, d in distances.items() if d < 15.0} == {}


@pytest.mark.parametrize(("colours", "page"), [(LIGHT, LIGHT_PAGE), (DARK, DARK_PAGE)], ids=["light", "dark"])
def test_every_colour_is_seen_on_its_page(colours, page):
    assert min(contrast(c, page) for c in colours) >= 3.0


def test_36_curves_of_a_chart_look_different_and_the_first_six_differ_in_dashes_too():
    assert len({look(i) for i in range(36)}) == 36
    assert len({look(i).dashes for i in range(6)}) == 6
    assert palette.DOTS not in palette.DASHES
