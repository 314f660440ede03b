"""
Charts as JSON for the page's script; arrays as base64, each once however many curves share it.

An array is `{first, step, n}` where its values are equally spaced, else 32-bit numbers less the middle of
their range, which are exact to 6e-8 of that range, or 64-bit numbers where the range is too large for that.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from markupsafe import Markup

from .chart import Chart, Floats

_LARGEST = 1e37
_EQUALLY_SPACED = 1e-6


@dataclass
class Arrays:
    """The arrays of a page."""

    encoded: list[dict[str, Any]] = field(default_factory=list)
    _places: dict[bytes, int] = field(default_factory=dict)

    def place(self, values: Floats) -> int:
        """Return the place of an array of shape (n,) in the page's list."""
        values = np.ascontiguousarray(values, dtype=float)
        key = values.tobytes()
        if key not in self._places:
            self._places[key] = len(self.encoded)
            self.encoded.append(encoded(values))
        return self._places[key]


def encoded(values: Floats) -> dict[str, Any]:
    """Encode one array of shape (n,); what is not finite becomes NaN."""
    values = np.where(np.isfinite(values), values, np.nan)
    if len(values) > 2 and np.isfinite(values).all():
        step = float(values[-1] - values[0]) / (len(values) - 1)
        if np.max(np.abs(values - values[0] - step * np.arange(len(values)))) <= _EQUALLY_SPACED * abs(step):
            return {"first": float(values[0]), "step": step, "n": len(values)}
    finite = values[np.isfinite(values)]
    if len(finite) and max(np.max(finite), -np.min(finite)) > _LARGEST:
        return {"f8": base64.b64encode(values.astype("<f8").tobytes()).decode()}
    middle = 0.5 * float(np.min(finite) + np.max(finite)) if len(finite) else 0.0
    return {"f4": base64.b64encode((values - middle).astype("<f4").tobytes()).decode(), "middle": middle}


def page_data(charts: Mapping[str, Sequence[Chart]]) -> Markup:
    """Return the content of the page's data element: arrays, and charts by the name of their place."""
    arrays = Arrays()
    named = {name: [_chart(chart, arrays) for chart in own] for name, own in charts.items()}
    text = json.dumps({"charts": named, "arrays": arrays.encoded}, allow_nan=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c"))


def _chart(chart: Chart, arrays: Arrays) -> dict[str, Any]:
    curves = [
        {
            "label": curve.label,
            "style": curve.style,
            "colour": None if look is None else look.colour,
            "dashes": [] if look is None else look.dashes,
            "x": arrays.place(curve.x),
            "y": arrays.place(curve.y),
        }
        for curve, look in zip(chart.curves, chart.looks, strict=True)
    ]
    return {
        "title": chart.title,
        "x_label": chart.x_label,
        "y_label": chart.y_label,
        "x_range": chart.x_range,
        "y_range": chart.y_range,
        "logarithmic": chart.logarithmic,
        "curves": curves,
        "regions": [
            {
                "x": arrays.place(r.x),
                "y": arrays.place(r.y),
                "fill": r.fill,
                "label": r.label,
                "bold": r.is_bold,
            }
            for r in chart.regions
        ],
    }
