"""Parameters of the answer: what was chosen, fitted once more with the blocks that it was selected by."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from master.diagnosis.numerics.arrays import Mask
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.study import OF_ANSWER, QUICK, Study
from master.diagnosis.unnamed_law.learn import relearned

from .part_result import PartResult, WithoutEffect


def refitted(result: PartResult) -> PartResult:
    """
    Fit base and chosen effects on all open rows of the recordings that are fitted on.

    The blocks to select by are no longer needed for that. Gains and tests are those of before, where they
    were held out; sealed rows stay sealed, and so do recordings that only select: they differ on purpose.
    """
    study = replace(result.study, fit_rows=open_rows(result.study))
    if result.is_exact:
        return result
    if np.array_equal(study.fit_rows, result.study.fit_rows):
        return replace(result, without=_without(study, result.chosen, result.fit, result.base))
    study.say("last fit")
    base = _again(study, ExtendedModel(), result.base)
    if result.learned is not None and result.learned.model == result.chosen:
        fit = relearned(study, result.learned, result.fit)
    else:
        fit = _again(study, result.chosen, result.fit) if result.has_effect else base
    return replace(result, base=base, fit=fit, without=_without(study, result.chosen, fit, base))


def open_rows(study: Study) -> Mask:
    """Rows to fit on, and those to select by in the same recordings; shape (rows,)."""
    bench = study.bench
    rows = study.fit_rows.copy()
    for block in study.held_out:
        rows[block] = True
    for recording, length in bench.lengths.items():
        if recording not in bench.fitted:
            begin = bench.begin(recording)
            rows[begin : begin + length] = False
    return rows


def _without(study: Study, chosen: ExtendedModel, fit: Fit, base: Fit) -> dict[str, WithoutEffect]:
    """Each effect's share is judged against the model that lacks it alone."""
    if len(chosen.effects) == 1:
        return {str(chosen.effects[0]): WithoutEffect(ExtendedModel(), base)}
    found = {}
    for placed in chosen.effects:
        less = chosen.without(placed)
        study.build([less.effects])
        found[str(placed)] = WithoutEffect(less, study.fitted(less, [fit.values], QUICK))
    return found


def _again(study: Study, model: ExtendedModel, before: Fit) -> Fit:
    return study.fitted(model, [before.values], OF_ANSWER)
