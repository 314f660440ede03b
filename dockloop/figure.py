"""Figures that a notebook shows whether pyplot is loaded there or not."""

from __future__ import annotations

import io

from matplotlib.figure import Figure

_DPI = 110


class ShownFigure(Figure):
    """A figure of Matplotlib that belongs to no window; notebooks ask it for a picture."""

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=_DPI)
        return buffer.getvalue()
