"""Picture of a stability map."""

from __future__ import annotations

from pathlib import Path

from master.pages.picture import draw, legend
from master.pages.plain_text import as_written

from .map_chart import map_chart
from .sweep import StabilityMap

_WHAT = "blue: decays, orange: grows, darker the faster; dashed: damping ratio of the fastest pole"


def plot_map(found: StabilityMap, title: str, path: Path) -> Path:
    """Draw growth over one axis, or growth and damping over two, as PNG."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.4, 5.2), layout="constrained")
    axis = figure.subplots()
    draw(axis, map_chart(found, title if found.y is None else f"{title}\n{_WHAT}"))
    axis.title.set_fontsize("medium")
    legend(figure, axis)
    as_written(figure).savefig(path, dpi=120)
    return path
