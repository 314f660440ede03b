"""Unit strings of the models (`N s/m`, `rad/s`, `1`) as SI exponents and display units for FMI."""

from __future__ import annotations

import re
from collections.abc import Mapping

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")

_SYMBOLS: Mapping[str, Mapping[str, int]] = {
    **{base: {base: 1} for base in BASE_UNITS},
    "1": {},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "Hz": {"s": -1},
}

DISPLAY_UNITS: Mapping[str, tuple[str, float]] = {
    "m": ("mm", 1e3),
    "s": ("ms", 1e3),
    "N": ("kN", 1e-3),
    "rad": ("deg", 57.29577951308232),
    "rad/s": ("deg/s", 57.29577951308232),
}

_FACTOR = re.compile(r"([A-Za-z]+|1)(?:\^?(-?\d+))?")


def si_exponents(unit: str) -> dict[str, int]:
    """
    Give the exponents of the SI base units, without zeros.

    A unit is a product of symbols with spaces between them, each with an optional exponent; all
    behind the one slash divides. Raises ValueError for an unknown symbol.
    """
    total = dict.fromkeys(BASE_UNITS, 0)
    for sign, side in zip((1, -1), unit.split("/", 1), strict=False):
        for factor in side.replace("(", " ").replace(")", " ").split():
            match = _FACTOR.fullmatch(factor)
            if match is None or match[1] not in _SYMBOLS:
                raise ValueError(
                    f"unit {unit!r}: unknown symbol, got {factor!r}, expected one of {[*_SYMBOLS]}"
                )
            for base, exponent in _SYMBOLS[match[1]].items():
                total[base] += sign * exponent * int(match[2] or 1)
    return {base: exponent for base, exponent in total.items() if exponent}
