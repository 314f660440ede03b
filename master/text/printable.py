"""Text for terminals and pages: what controls them is shown, not carried out."""

from __future__ import annotations

import unicodedata

_CONTROLLING = {"Cc", "Cf", "Cs", "Zl", "Zp"}  # controls, format (also of writing direction), half characters
_KEPT = {"\n", "\t"}


def printable(text: str) -> str:
    """Return a text with all that controls a terminal as escapes: `\\x1b[2J`."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(c if c in _KEPT or not _controls(c) else _escaped(c) for c in text)


def _controls(character: str) -> bool:
    return unicodedata.category(character) in _CONTROLLING


def _escaped(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
