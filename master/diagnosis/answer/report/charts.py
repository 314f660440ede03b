"""Charts of the page: what was measured and simulated, and what is left, to zoom into and to read."""

from __future__ import annotations

import numpy as np

from master.diagnosis.answer.before_after import SealedPart
from master.diagnosis.case.cut import CutSystem
from master.diagnosis.judge.part_result import PartResult
from master.diagnosis.numerics.arrays import Array
from master.pages.chart import LINE, REFERENCE, Chart, Curve, decimated

from .drawing import AFTER, BEFORE, GAP, MEASURED, MOST_BINS, label, unit_of
from .residual import residuals_of, spectrum_of

TIME = "time [s]"


def sealed_charts(system: CutSystem, own: SealedPart) -> list[Chart]:
    """Return two charts an output: measured and simulated, and the residual, measured less simulated."""
    charts = []
    for i, name in enumerate(own.part.compared):
        measured, before, after = (v[:, i] for v in (own.measured, own.before, own.after))
        simulated = {BEFORE: before} if np.array_equal(after, before) else {AFTER: after, BEFORE: before}
        curves = [curve(MEASURED, own.t, measured, REFERENCE)]
        curves += [curve(which, own.t, values) for which, values in simulated.items()]
        left = [curve(which, own.t, measured - values) for which, values in simulated.items()]
        charts += [
            Chart(name, TIME, label(system, name), curves),
            Chart(f"{name}: residual", TIME, f"residual [{unit_of(system, name)}]", left),
        ]
    return charts


def residual_charts(part: PartResult) -> list[Chart]:
    """Return the residual on the open rows over time, and its spectrum, of the output explained worst."""
    found = residuals_of(part)
    rows = part.study.bench.in_use
    t = np.asarray(np.flatnonzero(rows) * part.study.bench.row_period, dtype=float)
    over_time = [curve(which, t, values[rows]) for which, values in found.left.items()]
    spectra = [_spectrum(which, values, part) for which, values in found.left.items()]
    density = f"amplitude density [{found.unit}/sqrt(Hz)]"
    return [
        Chart(found.signal, TIME, f"residual [{found.unit}]", over_time),
        Chart(f"{found.signal}: spectrum", "frequency [Hz]", density, spectra, logarithmic=True),
    ]


def _spectrum(which: str, values: Array, part: PartResult) -> Curve:
    frequencies, density = spectrum_of(part, values)
    return Curve(which, frequencies, density)


def curve(which: str, t: Array, values: Array, style: str = LINE) -> Curve:
    """Return a curve over time, shapes (n,), in the order of time and broken where rows are missing."""
    order = np.argsort(t, kind="stable")
    t, values = t[order], values[order]
    steps = np.diff(t)
    gaps = np.flatnonzero(steps > GAP * float(np.median(steps))) + 1 if len(steps) else np.zeros(0, int)
    x = np.insert(t, gaps, 0.5 * (t[gaps - 1] + t[gaps]))
    return decimated(Curve(which, x, np.insert(values, gaps, np.nan), style), MOST_BINS)
