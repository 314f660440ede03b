"""
Colours that people who do not see green tell apart, and that are seen on their page.

Sight without the cone for green: Machado, Oliveira, Fernandes, IEEE Trans. Vis. Comput. Graph. 15 (2009)
1291-1298, severity 1, in linear RGB. Lab of CIE 1976 with white D65; contrast of WCAG 2.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from master.pages import palette
from master.pages.palette import DARK, DARK_PAGE, LIGHT, LIGHT_PAGE, look

DEUTERANOPIA = np.array(
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
)
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def linear(colour: str):
    rgb = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def lab(rgb):
    xyz = XYZ @ np.clip(rgb, 0.0, 1.0) / (XYZ @ np.ones(3))
    x, y, z = np.where(xyz > 216 / 24389, np.cbrt(xyz), (24389 / 27 * xyz + 16) / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def contrast(one: str, other: str) -> float:
    low, high = sorted(float(XYZ[1] @ linear(c)) for c in (one, other))
    return (high + 0.05) / (low + 0.05)


def test_the_measures_agree_with_known_values():
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert lab(linear("#ff0000")) == pytest.approx([53.24, 80.09, 67.20], abs=0.05)


@pytest.mark.parametrize("colours", [LIGHT, DARK], ids=["light", "dark"])
@pytest.mark.parametrize("sight", [np.eye(3), DEUTERANOPIA], ids=["all cones", "no green"])
def test_any_two_colours_are_told_apart(colours, sight):
    seen = [lab(sight @ linear(c)) for c in colours]
    distances = {(a, b): np.linalg.norm(seen[a] - seen[b]) for a, b in itertools.combinations(range(6), 2)}

    assert {pair: d for pair, d in distances.items() if d < 15.0} == {}


@pytest.mark.parametrize(("colours", "page"), [(LIGHT, LIGHT_PAGE), (DARK, DARK_PAGE)], ids=["light", "dark"])
def test_every_colour_is_seen_on_its_page(colours, page):
    assert min(contrast(c, page) for c in colours) >= 3.0


def test_36_curves_of_a_chart_look_different_and_the_first_six_differ_in_dashes_too():
    assert len({look(i) for i in range(36)}) == 36
    assert len({look(i).dashes for i in range(6)}) == 6
    assert palette.DOTS not in palette.DASHES
