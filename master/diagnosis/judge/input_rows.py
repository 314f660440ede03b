"""
Rows of the measured inputs of foreign FMUs: at the start of a step, or at its end.

What a foreign FMU says of its outputs, or leaves open, decides first (`master/diagnosis/case/cut.py`). Other
recorders save an output a row later, and not every FMU describes itself well: so, where a case does not name
the row, the other one is tried, and taken where the held-out blocks say so.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from master.diagnosis.case.case import Case
from master.diagnosis.case.cut import CutPart, CutSystem, MeasuredInput
from master.diagnosis.numerics.gains import gain_over, is_accepted

from .part_result import PartResult

LEAST_SHARE = 0.5  # of the residual power: an effect that is missing looks a little like another row
NEGLIGIBLE = 1e-12  # share of the power of the residual: what is left is rounding
MOST_FREE = 3  # inputs of which all combinations are tried; of more, one at a time and all


def other_rows(system: CutSystem, part: CutPart, case: Case) -> Iterator[CutPart]:
    """Yield the part with the other row for some of the inputs that the case leaves open."""
    free = [
        names
        for fmu in part.fmus
        for names in _taken_together(system, part, fmu)
        if all(case.inputs[f"{fmu}.{variable}"].at is None for _, variable in names)
    ]
    sizes = range(1, len(free) + 1) if len(free) <= MOST_FREE else (1, len(free))
    for size in sizes:
        for chosen in itertools.combinations(free, size):
            inputs = {fmu: dict(own) for fmu, own in part.inputs.items()}
            for fmu, variable in itertools.chain.from_iterable(chosen):
                given = inputs[fmu][variable]
                inputs[fmu][variable] = MeasuredInput(given.signal, "start" if given.row == "end" else "end")
            yield replace(part, inputs=inputs)


def _taken_together(system: CutSystem, part: CutPart, fmu: str) -> list[list[tuple[str, str]]]:
    """Measured inputs `(fmu, variable)` of a foreign FMU, each with what a follower needs next to it."""
    if fmu in system.carriers:
        is_before = system.carriers[fmu].side == "input"
        return [[(fmu, variable) for variable in part.inputs[fmu]]] if is_before else []
    return [[(fmu, variable)] for variable in part.inputs[fmu]] if system.model(fmu) is None else []


def is_better(first: PartResult, other: PartResult, n_tried: int) -> bool:
    """Whether other rows explain the measurement clearly better, on the held-out blocks."""
    if first.is_exact or other.is_exact:
        return other.is_exact and not first.is_exact
    study = first.study
    before, after = study.powers(first.base.predicted), study.powers(other.base.predicted)
    if np.all(after <= NEGLIGIBLE * before):
        return bool(before.any())
    if np.all(before <= NEGLIGIBLE * after):
        return False
    found = gain_over(first.base, other.base, study.measured, study.held_out, study.output_scale)
    return found.share > LEAST_SHARE and is_accepted(found, n_tried, is_first=False)


def changed_rows(before: CutPart, after: CutPart) -> Mapping[str, str]:
    """Inputs `fmu.variable` whose rows differ, with the one that is taken."""
    return {
        f"{fmu}.{variable}": given.row
        for fmu, own in after.inputs.items()
        for variable, given in own.items()
        if given.row != before.inputs[fmu][variable].row
    }
