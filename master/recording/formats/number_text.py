"""
Numbers as programs print them: a decimal point or a decimal comma, as the cells themselves prove.

`1,5` can only hold a decimal comma, `1,234.5` only a decimal point; `1,234` may be either, and nothing is
guessed: another cell has to prove it, or it is no number.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

_POINT = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_COMMA = re.compile(r"[+-]?(\d+,?\d*|,\d+)([eE][+-]?\d+)?")
_POINT_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+(\.\d*)?")
_COMMA_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(\.\d{3})+(,\d*)?")
_WORDS = frozenset({"nan", "+nan", "-nan", "inf", "+inf", "-inf", "infinity", "+infinity", "-infinity"})
_ONE_OF_TWO = "a number whose decimal sign the column shows: ',' and '.' may both be between thousands"
MISSING = frozenset({"", "na", "n/a", "#n/a", "null", "none", "nil", "missing"})


def looks_like_number(cell: str) -> bool:
    """Return whether a text is a number with either sign as the decimal one."""
    return bool(readings(cell)) or cell.lower() in _WORDS


def readings(cell: str) -> set[str]:
    """Return the decimal signs with which a text is a number; both where it has neither sign."""
    found = set()
    if _POINT.fullmatch(cell) or _POINT_GROUPED.fullmatch(cell):
        found.add(".")
    if _COMMA.fullmatch(cell) or _COMMA_GROUPED.fullmatch(cell):
        found.add(",")
    return found if cell.isascii() else set()


def proven(cells: Iterable[str]) -> set[str]:
    """Return the decimal signs that some cell can only be read with."""
    signs: set[str] = set()
    for cell in cells:
        found = readings(cell) if "," in cell or "." in cell else set()
        if len(found) == 1:
            signs |= found
            if len(signs) > 1:
                break
    return signs


def number(cell: str, decimal: str | None, *, is_proven: bool) -> float:
    """
    Return the number of a cell.

    Args:
        cell: Without blanks around it.
        decimal: Its decimal sign; None where nothing decides.
        is_proven: Whether the cell's own column proves the sign; else no sign between thousands is taken.

    Raises:
        ValueError: If it is none, or one of two; the text says what was expected.
    """
    if cell.lower() in _WORDS:
        return float(cell)
    signs = readings(cell)
    if not signs:
        raise ValueError("a number")
    has_sign = "," in cell or "." in cell
    if has_sign and len(signs) > 1 and decimal is None:
        raise ValueError(_ONE_OF_TWO)
    if decimal is not None and decimal not in signs:
        raise ValueError("a number")
    used = decimal if decimal in signs else next(iter(signs))
    group = "," if used == "." else "."
    if group in cell and not is_proven:
        raise ValueError(_ONE_OF_TWO)
    return float(cell.replace(group, "").replace(",", "."))
