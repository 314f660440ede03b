"""One law in both outflows of two tanks, each of which alone hardly explains anything, as formulas."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from fmu_sources.docking_contact.docking_contact import MODEL as CONTACT
from fmu_sources.effects.framework.effect import Rms
from fmu_sources.rigs.two_tanks import MODEL as TANKS
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.search import several_slots
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.rounds import SearchResult
from master.diagnosis.search.several_slots import together, with_laws_in_several_slots
from master.diagnosis.search.study import Study

N = 1200
BLOCKS = [slice(100 * i, 100 * (i + 1)) for i in range(1, 12, 2)]
T = np.arange(N) * 0.1
LARGE = 10.0 * np.sin(0.7 * T)
SMALL = np.cos(1.9 * T)
ROOTS = [PlacedEffect("tanks", slot, "power_law") for slot in ("upper_outflow", "lower_outflow")]
OFFSETS = [PlacedEffect("tanks", slot, "offset") for slot in ("upper_outflow", "lower_outflow")]


def predicted(effects, values):
    """Each outflow moves the level by much, against the other; what is left of both is missing."""
    sizes = [values.get(placed.variable("amplitude"), 0.0) for placed in ROOTS]
    y = sizes[0] * (SMALL + LARGE) + sizes[1] * (SMALL - LARGE)
    return y[:, None]


@pytest.fixture
def study(study_of, monkeypatch):
    def simulate(self, effects, values, everything=False):
        return predicted(effects, values)

    monkeypatch.setattr(Study, "simulate", simulate)
    monkeypatch.setattr(Study, "signal_rms", lambda self, place: Rms(value=0.1, position=5.0))
    monkeypatch.setattr(Study, "_with_start_values", lambda self, model, starts: (model, list(starts)))
    monkeypatch.setattr(several_slots, "search", lambda *_, begun, **__: begun)
    noise = 0.01 * np.random.default_rng(3).standard_normal(N)
    measured = (2.0 * 0.05 * SMALL + noise)[:, None]
    rows = np.ones(N, dtype=bool)
    for block in BLOCKS:
        rows[block] = False
    system = SimpleNamespace(slots=slots, values={"tanks": {}})
    return study_of(measured, BLOCKS, fit_rows=rows, system=system)


def slots(fmu):
    return {slot.name: slot for slot in {"tanks": TANKS, "contact": CONTACT}[fmu].slots}


def ended(study, effects=()):
    base = Fit("base", {}, {}, predicted((), {}), 0.0)
    return SearchResult(base, ExtendedModel(effects), base, ())


def test_a_law_that_each_slot_alone_contradicts_is_found_in_both(study):
    result = with_laws_in_several_slots(study, ended(study), [*ROOTS, *OFFSETS], lambda _: False)

    assert result.model.effects == tuple(ROOTS)
    assert [result.fit.values[e.variable("amplitude")] for e in ROOTS] == pytest.approx(
        [0.05, 0.05], rel=0.02
    )
    assert np.std(result.fit.predicted - study.measured) < 0.011


def ended_with(residual, study):
    """The end of a search that leaves a residual (N,)."""
    fit = Fit("one", {}, {}, study.measured - residual[:, None], 0.0)
    base = Fit("base", {}, {}, predicted((), {}), 0.0)
    return SearchResult(base, ExtendedModel((OFFSETS[0],)), fit, ())


def test_one_block_that_another_law_hits_by_accident_does_not_outweigh_the_others(study):
    """It leaves four times the noise's power in five blocks of six, and 1/400 in one: a logarithm of -6."""
    residual = 0.02 * np.random.default_rng(11).standard_normal(N)
    residual[BLOCKS[2]] *= 0.025

    result = with_laws_in_several_slots(study, ended_with(residual, study), ROOTS, lambda _: False)

    assert result.model.effects == tuple(ROOTS)


def test_an_end_that_leaves_as_much_is_kept(study):
    for seed in range(12, 32):
        found = ended_with(0.01 * np.random.default_rng(seed).standard_normal(N), study)

        assert with_laws_in_several_slots(study, found, ROOTS, lambda _: False) is found


def test_where_one_after_the_other_is_adequate_nothing_more_is_tried(study):
    result = ended(study)

    assert with_laws_in_several_slots(study, result, ROOTS, lambda _: True) is result


def test_only_a_law_of_the_position_goes_into_slots_of_a_kind(study):
    contact = [PlacedEffect("contact", slot, "ripple") for slot in ("rope_force", "guide_force")]

    assert together(study, [*OFFSETS, *ROOTS, *contact]) == [tuple(ROOTS)]
    assert together(study, [ROOTS[0], *OFFSETS]) == []
