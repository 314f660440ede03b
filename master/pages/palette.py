"""
Colours and line styles of curves, for light and dark pages.

No two curves of a chart have the same colour and the same dashes. The colours are at least 15 apart (CIE 1976
delta E) for people who do not see green, and their contrast to the page is 3 at least: a test computes both.
Source   Okabe, Ito, Color Universal Design (2008); darkened for white pages, lightened for dark ones.
"""

from __future__ import annotations

from typing import NamedTuple

LIGHT = ("#0072b2", "#c44e00", "#00855f", "#b0458f", "#1b1f24", "#704800")
DARK = ("#5fb8ee", "#ff8b4a", "#1fc396", "#f0a6d8", "#f2f5f8", "#f2d04b")
LIGHT_PAGE, DARK_PAGE = "#ffffff", "#14181d"
LIGHT_REFERENCE, DARK_REFERENCE = "#b4b9be", "#5d656d"
LIGHT_SOFT, DARK_SOFT = "#56606a", "#a3adb7"  # less important text, and events

SOLID: tuple[float, ...] = ()
DASHES = (SOLID, (9.0, 4.0), (11.0, 4.0, 2.0, 4.0), (5.0, 3.0), (16.0, 4.0), (9.0, 3.0, 2.0, 3.0, 2.0, 3.0))
DOTS = (2.0, 3.0)


class Look(NamedTuple):
    """How a curve is drawn: place of its colour in the palette, and its dashes [px]."""

    colour: int
    dashes: tuple[float, ...]


def look(place: int) -> Look:
    """Look of the curve at a place of its chart; 36 differ."""
    n = len(LIGHT)
    return Look(place % n, DASHES[(place + place // n) % n])
