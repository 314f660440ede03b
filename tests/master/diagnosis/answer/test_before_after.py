"""Before and after on the sealed rows: which rows, which files, which numbers."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from master.diagnosis.answer import before_after
from master.diagnosis.answer.before_after import SealedPart, sealed
from master.diagnosis.case.cut import CutPart
from master.diagnosis.case.split import Sealed, Stretch
from master.diagnosis.numerics.error_measures import errors
from master.diagnosis.replay.replay_bench import Estimated, Segment

PART = CutPart(("box",), {"box": {}}, {"box": {}}, {"box.a": "a", "box.b": "b"})
N = 20


def test_errors_by_hand():
    found = errors(np.array([3.0, 4.0, 0.0, 0.0]), np.array([3.0, 2.0, 0.0, 0.0]))

    assert found.rmse == pytest.approx(1.0)
    assert found.nrmse_percent == pytest.approx(100.0 / 2.5)
    assert found.max == 2.0
    assert found.energy == pytest.approx(13.0 / 25.0)
    assert found.rmse_interval.low <= 1.0 <= found.rmse_interval.high


def test_a_prediction_that_is_not_finite_has_no_errors():
    found = errors(np.ones(3), np.array([1.0, np.nan, 1.0]))

    assert (found.rmse, found.max, found.energy, found.rmse_interval) == (None, None, None, None)


def test_explained_share_is_the_mean_over_the_outputs():
    """Half the amplitude left of one output is a quarter of its power, nothing left of the other."""
    zero = np.zeros((4, 2))
    before = np.column_stack([np.full(4, 2.0), np.full(4, 1e3)])
    after = np.column_stack([np.full(4, 1.0), np.zeros(4)])

    assert SealedPart(PART, np.arange(4), zero, before, after, before).explained_share == pytest.approx(0.875)


def test_an_output_that_is_exact_before_does_not_count():
    zero = np.zeros((4, 2))
    before = np.column_stack([np.zeros(4), np.full(4, 2.0)])

    assert SealedPart(PART, np.arange(4), zero, before, zero, before).explained_share == 1.0
    assert SealedPart(PART, np.arange(4), zero, zero, zero, zero).explained_share == 0.0


@pytest.fixture
def diagnosis():
    """One part, 20 rows of one recording; rows 12 to 17 are sealed, row 13 settles."""
    in_use = np.ones(N, dtype=bool)
    in_use[13] = False
    bench = SimpleNamespace(
        part=PART,
        lengths={"r": N},
        begin={"r": 0}.get,
        measured=np.arange(2.0 * N).reshape(N, 2),
        in_use=in_use,
        row_period=0.1,
        estimates={},
        looked_at=lambda: np.zeros(N, dtype=bool),
    )
    bench.afresh = lambda: bench
    part = SimpleNamespace(
        name="box",
        study=SimpleNamespace(bench=bench),
        base=SimpleNamespace(values={"box.k": 1.0}),
        has_effect=True,
        values={"box.k": 2.0, "box.new": 3.0},
        without={},
        search=None,
    )
    return SimpleNamespace(
        system=None,
        parts=(part,),
        recordings={"r": None},
        split=SimpleNamespace(sealed=Sealed([Stretch("r", 12, 17)])),
    )


def test_before_runs_the_old_files_and_after_those_that_are_handed_over(diagnosis, monkeypatch):
    runs = []

    def run(bench, system, files, values):
        runs.append((dict(files), dict(values)))
        return before_after.Run(bench.measured + len(runs), None)

    monkeypatch.setattr(before_after, "_files", lambda system, part: {"box": "old.fmu"})
    monkeypatch.setattr(before_after, "_run", run)

    found = sealed(diagnosis, {"box": "new.fmu", "elsewhere": "other.fmu"})["box"]

    assert runs == [
        ({"box": "old.fmu"}, {"box.k": 1.0}),
        ({"box": "old.fmu"}, {}),
        ({"box": "new.fmu"}, {"box.k": 2.0, "box.new": 3.0}),
    ]
    assert found.t == pytest.approx([1.2, 1.4, 1.5, 1.6])
    assert found.measured[:, 0].tolist() == [24.0, 28.0, 30.0, 32.0]
    assert np.array_equal(found.before, found.measured + 1.0)
    assert np.array_equal(found.nominal, found.measured + 2.0)
    assert np.array_equal(found.after, found.measured + 3.0)


def test_rows_on_which_a_replay_found_values_of_its_own_are_left_out(diagnosis, monkeypatch):
    bench = diagnosis.parts[0].study.bench
    looked_at = np.zeros(N, dtype=bool)

    def run(bench, system, files, values):
        looked_at[:15] = True  # while it is replayed
        return before_after.Run(bench.measured, None)

    bench.looked_at = lambda: looked_at
    monkeypatch.setattr(before_after, "_files", lambda system, part: {"box": "old.fmu"})
    monkeypatch.setattr(before_after, "_run", run)

    assert sealed(diagnosis, {})["box"].t == pytest.approx([1.5, 1.6])


def test_sealed_rows_that_were_all_looked_at_are_scored_and_said_to_be(diagnosis, monkeypatch):
    bench = diagnosis.parts[0].study.bench
    segment = Segment("r", 0, N)
    bench.looked_at = lambda: np.ones(N, dtype=bool)
    bench.estimates = {segment: Estimated(("box.y0",), 18)}
    monkeypatch.setattr(before_after, "_files", lambda system, part: {"box": "old.fmu"})
    monkeypatch.setattr(before_after, "_run", lambda bench, *_: before_after.Run(bench.measured, None))
    found = sealed(diagnosis, {})["box"]

    assert found.t == pytest.approx([1.2, 1.4, 1.5, 1.6])
    assert found.estimates[segment].rows == N


def test_the_seal_is_broken_once(diagnosis, monkeypatch):
    monkeypatch.setattr(before_after, "_files", lambda system, part: {})
    monkeypatch.setattr(
        before_after, "_run", lambda bench, system, files, values: before_after.Run(bench.measured, None)
    )
    sealed(diagnosis, {})

    with pytest.raises(RuntimeError, match="read before"):
        sealed(diagnosis, {})
