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
    for text in _texts(figure):
        text.set_usetex(False)
        if "$" in text.get_text():
            text.set_parse_math(False)
    return figure


def _texts(figure: Any) -> Iterator[Any]:
    """All texts but the numbers at the axes, which a search of everything would have to make first."""
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.text import Text

    for artist in figure.get_children():
        if not isinstance(artist, Axes):
            yield from artist.findobj(Text)
            continue
        for part in artist.get_children():
            if not isinstance(part, Axis):
                yield from part.findobj(Text)
        yield artist.xaxis.label
        yield artist.yaxis.label
