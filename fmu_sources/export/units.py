"""
The one unit parser: from a name (`N s/m`, `kg.m2/s2`, `1/min`, `degF`) to SI, exactly.

    value in SI = factor * value + offset,   SI = product of kg m s A K mol cd rad to their exponents

Grammar    Spaces, dots, stars and middle dots multiply; a slash divides by the factor or the parentheses
           after it, and may come again (`m/s/s`); a factor after that needs parentheses, since `W/m2 K`
           is read in two ways. Exponents: `m2`, `m^2`, `m**2`, `s-1`, superscripts.
Symbols    As in SI, plus those of the list below; micro as u or with its sign. `g` is the gram, `gn` the
           standard gravity. `lb ft` and `lb in` alone are torques (pound-force); `lb` is a mass elsewhere.
Offsets    Only of a temperature alone: `W/degC` is per difference.
Source     SI Brochure, 9th ed.; NIST SP 811 (2008), App. B: inch, pound, calorie-free factors are exact.

FMUs of this project, unit names in other FMUs, and recordings are all read here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")

DISPLAY_UNITS: Mapping[str, tuple[str, float]] = {
    "m": ("mm", 1e3),
    "s": ("ms", 1e3),
    "N": ("kN", 1e-3),
    "rad": ("deg", 57.29577951308232),
    "rad/s": ("deg/s", 57.29577951308232),
}

PI = Fraction("3.14159265358979323846264338327950288419716939937511")
_POUND = Fraction("0.45359237")
_GRAVITY = Fraction("9.80665")
_INCH = Fraction("0.0254")
_POUND_FORCE = _POUND * _GRAVITY
_FAHRENHEIT = Fraction(5, 9)
_MOST_POWER = 20


@dataclass(frozen=True)
class Scale:
    """A unit in SI: exponents of the base units without zeros, factor and offset."""

    exponents: Mapping[str, int] = field(default_factory=dict)
    factor: Fraction = Fraction(1)
    offset: Fraction = Fraction(0)

    def times(self, other: Scale, power: int = 1) -> Scale:
        """Multiply with a power of another unit; a product has no offset."""
        total = dict(self.exponents)
        for base, exponent in other.exponents.items():
            total[base] = total.get(base, 0) + power * exponent
        return Scale({b: n for b, n in total.items() if n}, self.factor * other.factor**power)


_KILOGRAM = Scale({"kg": 1})
_METRE = Scale({"m": 1})
_SECOND = Scale({"s": 1})
_AMPERE = Scale({"A": 1})
_KELVIN = Scale({"K": 1})
_RADIAN = Scale({"rad": 1})


def _derived(**exponents: int) -> Scale:
    return Scale(exponents)


def _of(unit: Scale, factor: Fraction | int | str) -> Scale:
    return Scale(unit.exponents, Fraction(factor))


_NEWTON = _derived(kg=1, m=1, s=-2)
_PASCAL = _derived(kg=1, m=-1, s=-2)
_LITRE = _of(_derived(m=3), "0.001")

_PREFIXES = {
    "": Fraction(1),
    "p": Fraction(1, 10**12),
    "n": Fraction(1, 10**9),
    "u": Fraction(1, 10**6),
    "m": Fraction(1, 10**3),
    "k": Fraction(10**3),
    "M": Fraction(10**6),
    "G": Fraction(10**9),
}
_WITH_PREFIXES = {
    "m": _METRE,
    "s": _SECOND,
    "g": _of(_KILOGRAM, "0.001"),
    "A": _AMPERE,
    "K": _KELVIN,
    "mol": _derived(mol=1),
    "cd": _derived(cd=1),
    "rad": _RADIAN,
    "N": _NEWTON,
    "Pa": _PASCAL,
    "bar": _of(_PASCAL, 10**5),
    "J": _derived(kg=1, m=2, s=-2),
    "W": _derived(kg=1, m=2, s=-3),
    "V": _derived(kg=1, m=2, s=-3, A=-1),
    "Ohm": _derived(kg=1, m=2, s=-3, A=-2),
    "S": _derived(kg=-1, m=-2, s=3, A=2),
    "F": _derived(kg=-1, m=-2, s=4, A=2),
    "H": _derived(kg=1, m=2, s=-2, A=-2),
    "Wb": _derived(kg=1, m=2, s=-2, A=-1),
    "T": _derived(kg=1, s=-2, A=-1),
    "Hz": _derived(s=-1),
    "l": _LITRE,
    "L": _LITRE,
}
_WITHOUT_PREFIXES = {
    "1": Scale(),
    "count": Scale(),
    "%": _of(Scale(), "0.01"),
    "cm": _of(_METRE, "0.01"),
    "dm": _of(_METRE, "0.1"),
    "in": _of(_METRE, _INCH),
    "ft": _of(_METRE, 12 * _INCH),
    "min": _of(_SECOND, 60),
    "h": _of(_SECOND, 3600),
    "t": _of(_KILOGRAM, 1000),
    "lb": _of(_KILOGRAM, _POUND),
    "lbf": _of(_NEWTON, _POUND_FORCE),
    "kip": _of(_NEWTON, 1000 * _POUND_FORCE),
    "psi": _of(_PASCAL, _POUND_FORCE / _INCH**2),
    "hPa": _of(_PASCAL, 100),
    "gn": _of(_derived(m=1, s=-2), _GRAVITY),
    "deg": _of(_RADIAN, PI / 180),
    "rev": _of(_RADIAN, 2 * PI),
    "rpm": _of(_derived(rad=1, s=-1), 2 * PI / 60),
    "degC": Scale({"K": 1}, Fraction(1), Fraction("273.15")),
    "degF": Scale({"K": 1}, _FAHRENHEIT, _FAHRENHEIT * Fraction("459.67")),
}

SYMBOLS: Mapping[str, Scale] = {
    **{
        prefix + name: Scale(unit.exponents, unit.factor * scale)
        for prefix, scale in _PREFIXES.items()
        for name, unit in _WITH_PREFIXES.items()
    },
    **_WITHOUT_PREFIXES,
}
_TORQUES = {
    frozenset({"lb", length}): _of(_derived(kg=1, m=2, s=-2), _POUND_FORCE * size)
    for length, size in (("ft", 12 * _INCH), ("in", _INCH))
}

_RAISED = "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079\u207b"
_SAME = str.maketrans(
    {
        "\u00b5": "u",
        "\u03bc": "u",
        "\u03a9": "Ohm",
        "\u2126": "Ohm",
        "\u00b0": "deg",
        "\u00b7": " ",
        "\u22c5": " ",
        "*": " ",
        **dict(
            zip(
                "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079\u207b",
                "0123456789-",
                strict=True,
            )
        ),
    }
)
_TOKEN = re.compile(
    r"\s*(?:(?P<symbol>[A-Za-z]+|1(?![0-9])|%)(?:\^?(?P<power>[-+]?[0-9]+))?|(?P<sign>[/().]))"
)


@dataclass(frozen=True)
class _Token:
    text: str
    power: int = 1


@cache
def scale_of(unit: str) -> Scale:
    """
    Understand the name of a unit.

    Raises:
        ValueError: If a symbol is not known or the name is not a product of units.
    """
    tokens = list(_tokens(unit))
    factors = [t for t in tokens if t.text != "."]
    if all(t.power == 1 for t in factors):
        symbols = frozenset(t.text for t in factors)
        if len(factors) == 2 and symbols in _TORQUES:
            return _TORQUES[symbols]
        if len(factors) == 1 and factors[0].text in SYMBOLS:
            return SYMBOLS[factors[0].text]
    found, rest = _product(tokens, unit)
    if rest:
        raise ValueError(f"unit {unit!r}: ')' without '('")
    return found


def si_exponents(unit: str) -> dict[str, int]:
    """Return the exponents of the SI base units, without zeros; ValueError as `scale_of`."""
    exponents = scale_of(unit).exponents
    return {base: exponents[base] for base in BASE_UNITS if base in exponents}


def _tokens(unit: str) -> Iterator[_Token]:
    text = unit.replace("**", "^").translate(_SAME).strip()
    place = 0
    while place < len(text):
        match = _TOKEN.match(text, place)
        if match is None or (match["symbol"] and match["symbol"] not in SYMBOLS):
            part = text[place:].split()[0]
            raise ValueError(f"unit {unit!r}: unknown symbol, got {part!r}, expected {_known()}")
        power = int(match["power"] or 1)
        if abs(power) > _MOST_POWER:
            raise ValueError(f"unit {unit!r}: exponent, got {power}, expected at most {_MOST_POWER}")
        yield _Token(match["symbol"] or match["sign"], power)
        place = match.end()


def _known() -> str:
    prefixes = ", ".join(prefix for prefix in _PREFIXES if prefix)
    return (
        f"one of {', '.join(_WITH_PREFIXES)}, with a prefix of {prefixes}, or {', '.join(_WITHOUT_PREFIXES)}"
    )


def _product(tokens: list[_Token], unit: str) -> tuple[Scale, list[_Token]]:
    """Multiply factors up to the end or a closing parenthesis, and return what is left."""
    total, divides, has_divided = Scale(), False, False
    while tokens and tokens[0].text != ")":
        token, *tokens = tokens
        if token.text == ".":
            continue
        if token.text == "/":
            if divides:
                raise ValueError(f"unit {unit!r}: two slashes, expected a unit between them")
            divides = has_divided = True
            continue
        if has_divided and not divides:
            raise ValueError(
                f"unit {unit!r}: {token.text!r} after a slash is ambiguous, expected parentheses"
            )
        factor = Scale()
        if token.text == "(":
            factor, tokens = _product(tokens, unit)
            if not tokens:
                raise ValueError(f"unit {unit!r}: '(' without ')'")
            tokens = tokens[1:]
        else:
            factor = SYMBOLS[token.text]
        total = total.times(factor, -token.power if divides else token.power)
        divides = False
    if divides:
        raise ValueError(f"unit {unit!r}: nothing after a slash, expected a unit")
    return total, tokens
