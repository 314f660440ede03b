"""Is a compared signal what the case says? One that moves with the model at another size has a wrong unit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from master.diagnosis.case.case import LoadedCase
from master.diagnosis.numerics.likeness import size_against, slope_of_small

from .part_result import PartResult

MOST = 8.0  # below what confuses g with m/s2, mm with m, degrees with radians
EXPLAINED = 0.5  # of the deviation of what was measured: rms that a good refit stays below


def implausible(loaded: LoadedCase, parts: Sequence[PartResult]) -> list[str]:
    """Faults of signals whose size or sign is not the model's, and that no refit explains."""
    return [fault for part in parts for fault in _faults(loaded, part)]


def _faults(loaded: LoadedCase, part: PartResult) -> list[str]:
    rows = part.study.fit_rows
    problems = []
    for i, output in enumerate(part.outputs):
        measured = part.measured[rows, i]
        nominal = part.nominal[rows, i]
        refitted = part.base.predicted[rows, i]
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
