"""Units by the names that recordings use: `mm`, `kN`, `in/s`, `N s/m`."""

from __future__ import annotations

import re

from .units import Unit

POUND_FORCE = 4.4482216152605
GRAVITY = 9.80665

_NEWTON = {"kg": 1, "m": 1, "s": -2}
_PASCAL = {"kg": 1, "m": -1, "s": -2}
_VOLT = {"kg": 1, "m": 2, "s": -3, "A": -1}
SYMBOLS: dict[str, tuple[float, dict[str, int]]] = {
    "1": (1.0, {}),
    "%": (0.01, {}),
    **{name: (f, {"m": 1}) for name, f in [("m", 1.0), ("mm", 1e-3), ("um", 1e-6), ("cm", 1e-2)]},
    **{name: (f, {"m": 1}) for name, f in [("in", 0.0254), ("ft", 0.3048)]},
    **{name: (f, {"s": 1}) for name, f in [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("min", 60.0)]},
    **{name: (f, _NEWTON) for name, f in [("N", 1.0), ("kN", 1e3), ("mN", 1e-3)]},
    **{name: (f, _NEWTON) for name, f in [("lbf", POUND_FORCE), ("kip", 1e3 * POUND_FORCE)]},
    **{name: (f, _PASCAL) for name, f in [("Pa", 1.0), ("kPa", 1e3), ("MPa", 1e6), ("bar", 1e5)]},
    "psi": (POUND_FORCE / 0.0254**2, _PASCAL),
    **{name: (f, _VOLT) for name, f in [("V", 1.0), ("mV", 1e-3)]},
    **{name: (f, {"rad": 1}) for name, f in [("rad", 1.0), ("deg", 0.017453292519943295)]},
    **{name: (f, {"s": -1}) for name, f in [("Hz", 1.0), ("kHz", 1e3)]},
    "g": (GRAVITY, {"m": 1, "s": -2}),
    "kg": (1.0, {"kg": 1}),
    "A": (1.0, {"A": 1}),
    "K": (1.0, {"K": 1}),
}

_SIGNS = str.maketrans({"\u00b5": "u", "\u03bc": "u", "\u00b2": "2", "\u00b3": "3", "\u00b7": " ", "*": " "})
_FACTOR = re.compile(r"([A-Za-z]+|1|%)(?:\^?(-?\d+))?")


def unit(name: str) -> Unit:
    """
    Understand a product of symbols with exponents; all behind the one slash divides.

    Spaces, dots and stars multiply; micro and small exponents may be written as such.

    Raises:
        ValueError: If a symbol is not known.
    """
    factor, exponents = 1.0, dict[str, int]()
    for sign, side in zip((1, -1), name.translate(_SIGNS).split("/", 1), strict=False):
        for part in side.replace("(", " ").replace(")", " ").split():
            match = _FACTOR.fullmatch(part)
            if match is None or match[1] not in SYMBOLS:
                raise ValueError(f"unit {name!r}: unknown symbol, got {part!r}, expected one of {[*SYMBOLS]}")
            power = sign * int(match[2] or 1)
            scale, bases = SYMBOLS[match[1]]
            factor *= scale**power
            for base, exponent in bases.items():
                exponents[base] = exponents.get(base, 0) + power * exponent
    return Unit(name, {base: n for base, n in exponents.items() if n}, factor)
