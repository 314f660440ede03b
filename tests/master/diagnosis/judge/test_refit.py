from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from master.diagnosis.judge.refit import open_rows


def test_blocks_to_select_by_are_open_but_not_recordings_that_only_select():
    bench = SimpleNamespace(lengths={"a": 6, "b": 3}, fitted={"a"}, begin={"a": 0, "b": 6}.get)
    fit_rows = np.array([1, 1, 0, 0, 0, 1, 0, 0, 0], dtype=bool)  # row 2 is a guard
    study = SimpleNamespace(bench=bench, fit_rows=fit_rows, held_out=[slice(3, 5), slice(6, 9)])

    assert open_rows(study).astype(int).tolist() == [1, 1, 0, 1, 1, 1, 0, 0, 0]
    assert fit_rows.sum() == 3
