"""Runs compared from Python."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from master.errors import ConfigError, Problem
from master.runs.differences import Comparison, Demands, Tolerance, compare_runs
from master.runs.run_data import RunData, read_run

from .result import Run

Bound = float | str
"""A difference in the signal's unit, or a share of its largest magnitude as `"0.1%"`."""


def compare(
    reference: Run | str | Path,
    other: Run | str | Path,
    *,
    tolerance: Bound | Mapping[str, Bound] | None = None,
    signals: Iterable[str] = (),
    common: bool = False,
) -> Comparison:
    """
    Compare a run with a reference, signal by signal.

    Args:
        reference: A run, a results folder, or a CSV, Parquet, NPZ or MAT file.
        other: Likewise.
        tolerance: What differences are allowed, for all signals or by signal; None for equal bits.
        signals: The only signals to compare; all by default.
        common: Compare what both have; otherwise what only one has is a difference.

    Returns:
        The comparison: `is_within`, `faults` (a line each), `differences` by signal, `as_dict()`.

    Raises:
        ConfigError: If a tolerance or a signal is wrong.
        DataError: If a file cannot be read, or the runs have no signal or no time in common.
    """
    given = tolerance if isinstance(tolerance, Mapping) else {"": tolerance}
    read = {name: _tolerance(name, bound) for name, bound in given.items() if bound is not None}
    general = read.pop("", None)
    demands = Demands(general, read, tuple(signals), common)
    return compare_runs(_data(reference, "reference"), _data(other, "other"), demands)


def _tolerance(name: str, bound: Bound) -> Tolerance:
    try:
        return Tolerance.of(str(bound))
    except ValueError:
        where = f"tolerance {name}".strip()
        expected = "a number of at least 0 or a percentage"
        raise ConfigError([Problem("tolerance", where=where, got=repr(bound), expected=expected)]) from None


def _data(run: Run | str | Path, label: str) -> RunData:
    if isinstance(run, Run):
        return RunData(label, Path(), run.time, {name: run[name] for name in run.signals}, run.units)
    return read_run(Path(run))
