"""What a run keeps in memory."""

from __future__ import annotations

import pytest

from master.runs.execute import rows_in_memory


@pytest.mark.parametrize(
    ("n_signals", "n_rows"),
    [(0, 100_000), (1, 100_000), (335, 100_000), (336, 99_864), (10_000, 3355), (10**9, 1)],
)
def test_a_run_keeps_a_hundred_thousand_rows_but_no_more_than_256_mb_of_them(n_signals, n_rows):
    assert rows_in_memory(n_signals) == n_rows
    assert n_rows == 1 or 8 * n_signals * n_rows <= 2**28
