"""
The dataset of a campaign: a folder of Parquet files, one row a run, that grows while the campaign runs.

A file appears whole or not at all, so that pandas, Polars and DuckDB may read the folder at any moment.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.dataset as pads
import pyarrow.parquet as pq
from numpy.typing import NDArray

from master.errors import DataError
from master.recording.folder import reason

from .plan import Plan
from .stepper import Row

RUNS = "runs"
_PART, _PARTS = "part-{:06d}.parquet", "part-*.parquet"
_KINDS = {"b": pa.bool_(), "i": pa.int64(), "f": pa.float64()}


class Dataset:
    """
    Rows of a campaign on disk, in the folder `runs` of its output folder.

    `done` says of each run of the sample whether it has a row.
    """

    def __init__(self, folder: Path, plan: Plan) -> None:
        """
        Open the dataset, which may have rows.

        Raises:
            DataError: If it cannot be read.
        """
        self.path = folder / RUNS
        self.done: NDArray[np.bool_] = np.zeros(plan.sample.n_runs, dtype=bool)
        self._plan = plan
        self._folder = folder
        self._schema = schema(plan)
        self._rows: list[Row] = []
        self._n_parts = 0
        if any(self.path.glob(_PARTS)):
            self._look()

    @property
    def n_waiting(self) -> int:
        """Number of rows that are not on disk yet."""
        return len(self._rows)

    def add(self, row: Row) -> bool:
        """Take a row, unless its run has one; say whether it was taken."""
        if self.done[row.run]:
            return False
        self.done[row.run] = True
        self._rows.append(row)
        return True

    def flush(self) -> None:
        """
        Write the rows that wait, as one more file.

        Raises:
            DataError: If the disk does not take it; the files before it stay, and the rows wait on.
        """
        if not self._rows:
            return
        table = pa.Table.from_pydict(self._columns(), schema=self._schema)
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            _write_whole(table, self.path / _PART.format(self._n_parts), self._folder)
        except (OSError, pa.ArrowException) as error:
            raise DataError(f"{self.path}: cannot be written: {reason(error)}") from None
        self._n_parts += 1
        self._rows.clear()

    def keep_only(self, is_kept: NDArray[np.bool_]) -> int:
        """
        Remove the rows of all other runs, and return how many there were.

        Args:
            is_kept: Of each run of the sample, shape (runs,).

        Raises:
            DataError: If a file cannot be read or written; what has been removed then is removed.
        """
        self.flush()
        removed = int((self.done & ~is_kept).sum())
        try:
            for part in self.path.glob(_PARTS):
                table = pq.read_table(part)
                kept = table.filter(is_kept[table["run"].to_numpy()])
                if len(kept) == 0:
                    part.unlink()
                elif len(kept) < len(table):
                    _write_whole(kept, part, self._folder)
        except (OSError, pa.ArrowException) as error:
            raise DataError(f"{self.path}: cannot be written: {reason(error)}") from None
        self.done &= is_kept
        return removed

    def _look(self) -> None:
        try:
            runs = read_columns(self.path, ["run"])["run"]
        except (OSError, pa.ArrowException, KeyError) as error:
            raise DataError(f"{self.path}: cannot be read: {reason(error)}") from None
        self.done[runs[runs < len(self.done)]] = True
        numbers = [int(p.stem.rpartition("-")[2]) for p in self.path.glob(_PARTS)]
        self._n_parts = max(numbers, default=-1) + 1

    def _columns(self) -> dict[str, Any]:
        rows = self._rows
        plan = self._plan
        found: dict[str, Any] = {
            "run": [row.run for row in rows],
            "status": [row.status for row in rows],
            "message": [row.message for row in rows],
            "seed": [plan.seed_of(row.values) for row in rows],
            "wall_s": [row.wall for row in rows],
            "stepping_s": [row.stepping for row in rows],
            "t_end": [row.t_end for row in rows],
            "steps": [row.steps for row in rows],
        }
        runs = np.array(found["run"], dtype=np.int64)
        found |= {column.key: column.part(runs) for column in plan.sample.columns if column.key not in found}
        found |= {name: [row.numbers.get(name) for row in rows] for name in plan.numbers}
        found |= {name: [row.signals.get(name) for row in rows] for name in plan.signals}
        return found


def schema(plan: Plan) -> pa.Schema:
    """Return the columns of a campaign, with units and rates as metadata of the fields."""
    seconds = {"unit": "s"}
    fields = [
        pa.field("run", pa.int64()),
        pa.field("status", pa.string()),
        pa.field("message", pa.string()),
        pa.field("seed", pa.int64()),
        *(pa.field(name, pa.float64(), metadata=seconds) for name in ("wall_s", "stepping_s", "t_end")),
        pa.field("steps", pa.int64()),
    ]
    for column in plan.sample.columns:
        if column.key != "seed":
            kind = _KINDS.get(column.values.dtype.kind, pa.string())
            fields.append(pa.field(column.key, kind, metadata={"unit": column.unit}))
    for name in plan.numbers:
        fields.append(pa.field(name, pa.float64(), metadata={"unit": plan.units[name]}))
    step = plan.base.grid.step_size
    for name, every in plan.signals.items():
        told = {"unit": plan.units[name], "every": str(every), "step_s": repr(every * step)}
        fields.append(pa.field(name, pa.list_(pa.float64()), metadata=told))
    return pa.schema(fields)


def read_columns(path: Path, names: Sequence[str] | None = None) -> dict[str, NDArray[Any]]:
    """
    Read columns of a dataset as arrays, shape (rows,), in the order of its runs.

    Raises:
        OSError, pyarrow.ArrowException: If it cannot be read.
    """
    wanted = names if names is None else list(dict.fromkeys(["run", *names]))
    table = pads.dataset(path, format="parquet").to_table(columns=wanted)
    order = np.argsort(table["run"].to_numpy(), kind="stable")
    found = {name: table[name].to_numpy()[order] for name in table.column_names}
    return found if names is None else {name: found[name] for name in names}


def _write_whole(table: pa.Table, path: Path, folder: Path) -> None:
    """Write a file outside of the dataset first: a reader takes every file that it finds there."""
    with tempfile.NamedTemporaryFile(dir=folder, prefix=".part-", delete=False) as file:
        partial = Path(file.name)
    try:
        pq.write_table(table, partial, compression="zstd")
        os.chmod(partial, 0o644)
        partial.replace(path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
