"""Texts in pictures as they are: a name of an FMU is no formula."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any


def as_written(figure: Any) -> Any:
    """
    Let Matplotlib draw the texts of a figure as they are written, and return it.

    Between two `$` it would look for a formula, fail where there is none, and draw something else where
    there is. The numbers at the axes, which it writes as formulas itself, come later and are not touched.
    """
    from matplotlib import rcParams
    from matplotlib.text import Text

    found = figure.findobj(Text) if rcParams["text.usetex"] else _written(figure)
    for text in found:
        text.set_usetex(False)
        if "$" in text.get_text():
            text.set_parse_math(False)
    return figure


def _written(artist: Any) -> Iterator[Any]:
    """Texts of an artist but for numbers at the axes, which are made when they are asked for."""
    from matplotlib.axis import Axis
    from matplotlib.text import Text
    from matplotlib.ticker import LogFormatter, ScalarFormatter

    for child in artist.get_children():
        if isinstance(child, Axis):
            yield child.label
            if not isinstance(child.get_major_formatter(), LogFormatter | ScalarFormatter):
                yield from child.get_ticklabels()
        else:
            if isinstance(child, Text):
                yield child
            yield from _written(child)
