"""Is a compared signal what the case says? One that moves with the model at another size has a wrong unit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from master.diagnosis.case.case import LoadedCase
from master.diagnosis.numerics.arrays import Array

from .part_result import PartResult

ALIKE = 0.9  # correlation
MOST = 8.0  # below what confuses g with m/s2, mm with m, degrees with radians
EXPLAINED = 0.5  # of the rms, by the refit
SMALL, FEWEST = 0.5, 20  # of the largest value; rows


def implausible(loaded: LoadedCase, parts: Sequence[PartResult]) -> list[str]:
    """Faults of signals whose size or sign is not the model's, and that no refit explains."""
    return [fault for part in parts for fault in _faults(loaded, part)]


def _faults(loaded: LoadedCase, part: PartResult) -> list[str]:
    bench, rows = part.study.bench, part.study.fit_rows
    problems = []
    for i, output in enumerate(bench.outputs):
        measured, nominal, refitted = (
            values[rows, i] for values in (part.study.measured, part.nominal, part.base.predicted)
        )
        ratio = size_against(measured, nominal)
        is_other = _is_other(ratio) and _is_other(slope_of_small(measured, nominal))
        is_explained = np.sqrt(np.mean((refitted - measured) ** 2)) < EXPLAINED * measured.std()
        if not is_other or is_explained:
            continue
        name = loaded.case.compared[output]
        unit = loaded.case.signals[name].unit
        problems.append(
            f"{loaded.where('compared', output)}: moves like the model at another size, got {ratio:.3g} "
            f"times the model with {name!r} in {unit!r}, expected about 1: check unit, scale and sign, also "
            "of what drives the model"
        )
    return problems


def _is_other(ratio: float) -> bool:
    return not 1.0 / MOST < ratio < MOST


def slope_of_small(measured: Array, model: Array) -> float:
    """Slope over the model where the signal (n,) is small: about 1 for one that is cut off at its largest."""
    a, b = measured - measured.mean(), model - model.mean()
    rows = np.abs(a) < SMALL * np.abs(a).max()
    a, b = a[rows], b[rows]
    return float(a @ b / (b @ b)) if len(b) >= FEWEST and np.any(b) else 0.0


def size_against(measured: Array, model: Array) -> float:
    """Size of a signal (n,) over the model's, negative if it goes the other way; 1 if they are not alike."""
    a, b = measured - measured.mean(), model - model.mean()
    if not np.isfinite(b).all() or not np.any(a) or not np.any(b):
        return 1.0
    alike = float(a @ b / np.sqrt((a @ a) * (b @ b)))
    return float(np.sign(alike) * a.std() / b.std()) if abs(alike) > ALIKE else 1.0
