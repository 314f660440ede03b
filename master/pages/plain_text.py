"""Texts in pictures as they are: a name of an FMU is no formula."""

from __future__ import annotations

from typing import Any


def as_written(figure: Any) -> Any:
    """
    Let Matplotlib draw the texts of a figure as they are written, and return it.

    Between two `$` it would look for a formula, fail where there is none, and draw something else where
    there is. The numbers at the axes, which it writes as formulas itself, come later and are not touched.
    """
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        text.set_usetex(False)
        if "$" in text.get_text():
            text.set_parse_math(False)
    return figure
