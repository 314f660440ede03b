"""The figures as PNG files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .plot import CIRCLE, CROSS, DASHED, REFERENCE, Panel, colours

_STYLES: dict[str, dict[str, Any]] = {
    REFERENCE: {"linewidth": 3.0, "alpha": 0.6},
    DASHED: {"linestyle": "--", "linewidth": 1.2},
    CROSS: {"marker": "x", "linestyle": "none", "markersize": 7},
    CIRCLE: {"marker": "o", "linestyle": "none", "markersize": 8, "fillstyle": "none"},
}


def save(title: str, panels: Sequence[Panel], path: Path) -> Path:
    """Draw panels one below the other."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 3.0 * len(panels) + 0.6), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    axes = figure.subplots(len(panels), 1, squeeze=False)
    for axis, panel in zip(axes[:, 0], panels, strict=True):
        _panel(axis, panel)
    figure.savefig(path, dpi=110)
    return path


def _panel(axis: Any, panel: Panel) -> None:
    for curve, colour in zip(panel.curves, colours(panel), strict=True):
        style = {"linewidth": 1.2, **_STYLES.get(curve.style, {})}
        axis.plot(curve.x, curve.y, color=colour, label=curve.label, **style)
    axis.set(title=panel.title, xlabel=panel.x_label, ylabel=panel.y_label)
    axis.set_ylim(panel.y_range)
    if panel.x_range is None:
        axis.margins(x=0.0 if not any(c.style in (CROSS, CIRCLE) for c in panel.curves) else 0.05)
    else:
        axis.set_xlim(panel.x_range)
    axis.grid(alpha=0.3)
    axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize="small")
