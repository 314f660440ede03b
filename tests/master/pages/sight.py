"""
How colours are seen, also by people who do not see green, and whether two curves are told apart.

Sight without the cone for green: Machado, Oliveira, Fernandes, IEEE Trans. Vis. Comput. Graph. 15 (2009)
1291-1298, severity 1, in linear RGB. Lab of CIE 1976 with white D65; contrast of WCAG 2.
"""

from __future__ import annotations

import numpy as np

from master.pages.chart import EVENT, REFERENCE
from master.pages.palette import (
    DARK,
    DARK_REFERENCE,
    DARK_SOFT,
    LIGHT,
    LIGHT_REFERENCE,
    LIGHT_SOFT,
)

LEAST_DISTANCE = 15.0
GREYS = {
    LIGHT: {REFERENCE: LIGHT_REFERENCE, EVENT: LIGHT_SOFT},
    DARK: {REFERENCE: DARK_REFERENCE, EVENT: DARK_SOFT},
}
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


def distance(one: str, other: str, sight=DEUTERANOPIA) -> float:
    return float(np.linalg.norm(lab(sight @ linear(one)) - lab(sight @ linear(other))))


def apart(one, other, colours) -> bool:
    """Whether two curves, each with its look, differ in dashes or enough in colour."""
    (curve, own), (second, its) = one, other
    dashes = [() if look is None else look.dashes for look in (own, its)]
    seen = [
        GREYS[colours][c.style] if look is None else colours[look.colour]
        for c, look in ((curve, own), (second, its))
    ]
    return dashes[0] != dashes[1] or distance(*seen) >= LEAST_DISTANCE
