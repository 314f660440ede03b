"""
Result files that other tools open: CSV in FMPy's form, Parquet with units.

While a run writes row by row, its Parquet file is a series of parts, each complete, so that what was written
can be read whenever the process ends; they become one file when the run ends. The CSV file grows by whole
rows; a process that is killed may leave a last line without its end, which is no row.
"""

from __future__ import annotations

import contextlib
import errno
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Any

import numpy as np

from master.errors import DataError

from .folder import CSV, PARQUET, PARTS
from .recorder import Result
from .whole_file import appearing, sync_file, sync_folder

_PART_SECONDS = 0.5
_PART_SHARE = 0.02  # of the time since the first row, so that a run of hours has some hundred parts
_PART_BYTES = 2**26
_BLOCK_ROWS = 1000
_BLOCK_SECONDS = 0.1  # rows that come one by one are written in blocks
_GROUP_ROWS = 2**17  # of a row group, at most
_GROUP_BYTES = 2**26


@dataclass(frozen=True)
class FilesMark:
    """Where result files end that have reached the disk: rows, and bytes of the CSV file."""

    n_rows: int
    csv_bytes: int


class ResultFiles:
    """
    result.csv and result.parquet in a folder, written row by row or at once.

    CSV: `"time","instance.variable",...` with all digits, one row a communication point. Parquet: one
    column a signal, its unit in the field's metadata under `unit`.

    Methods raise OSError where a file cannot be written or was removed; `rescue` then saves what it can.
    """

    def __init__(self, folder: Path, *, at_once: bool = False, mark: FilesMark | None = None) -> None:
        """
        Begin files, or go on with those of a mark.

        Args:
            folder: Where they are; made if it is missing.
            at_once: Whether nobody has to see rows before all are there.
            mark: Up to where the files of an earlier process are kept.

        Raises:
            DataError: If the files do not reach to the mark.
        """
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self.csv = folder / CSV
        self.parquet = folder / PARQUET
        self.n_rows = 0
        self._at_once = at_once
        self._waiting: list[Any] = []
        self._looked = -np.inf
        self._csv: _Csv | None = None
        self._parts: _Parts | None = None
        if mark is not None:
            self._go_on(mark)

    def write(self, result: Result) -> None:
        """Append rows."""
        self._waiting.append(_table(result))
        if time.monotonic() - self._looked >= _BLOCK_SECONDS:
            self._looked = time.monotonic()
            self._write_waiting()

    def mark(self) -> FilesMark:
        """Let all rows written so far reach the disk; return where the files end then."""
        self._write_waiting()
        if self._csv is None or self._parts is None:
            return FilesMark(0, 0)
        n_bytes = self._csv.sync()
        self._parts.sync()
        sync_folder(self.folder)
        return FilesMark(self.n_rows, n_bytes)

    def close(self) -> None:
        """Write what is left, and make one Parquet file of the parts."""
        self._write_waiting()
        if self._csv is not None and self._parts is not None:
            if self._parts.is_durable:
                self._csv.sync()
            self._csv.close()
            self._csv.settle(self.csv)
            self._parts.join(self.parquet)

    def rescue(self, folder: Path | None = None) -> None:
        """
        After an OSError: keep every row that was written, in files that can be read.

        Args:
            folder: Where files are made that cannot be made in the first folder any more.
        """
        into = self.folder if folder is None else folder
        self._waiting.clear()
        if self._csv is None or self._parts is None:
            return
        self._csv.keep_whole_rows()
        with contextlib.suppress(OSError):
            self._csv.settle(self.csv)
        with contextlib.suppress(OSError):
            if not self._csv.is_in_place():
                into.mkdir(parents=True, exist_ok=True)
                self._csv.write_again(into / CSV)
                _parquet_of_csv(into / CSV, into / PARQUET, self._parts.schema)
            elif self._parts.is_empty() or into != self.folder:
                _parquet_of_csv(self.csv, into / PARQUET, self._parts.schema)
            else:
                self._parts.join(self.parquet)
        self._csv.close()

    def __enter__(self) -> ResultFiles:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _write_waiting(self) -> None:
        if not self._waiting:
            return
        import pyarrow as pa

        table = pa.concat_tables(self._waiting)
        if self._csv is None or self._parts is None:
            hidden = self.csv.with_name(f".{CSV}.new")
            self._csv = _Csv(hidden if self._at_once else self.csv, table.schema)
            self._parts = _Parts(self.folder, table.schema)
        self._waiting.clear()
        self._csv.write(table)
        self._parts.write(table)
        self.n_rows += len(table)

    def _go_on(self, mark: FilesMark) -> None:
        try:
            parts = _parts_up_to(mark.n_rows, self.folder)
            size = self.csv.stat().st_size
            if size < mark.csv_bytes:
                raise DataError(f"{self.csv}: is too short, got {size} bytes, expected {mark.csv_bytes}")
            if not parts:
                raise DataError(f"{self.folder}: no parts of {PARQUET}, expected {mark.n_rows} rows in them")
            schema = _schema_of(parts[0])
            self._csv = _Csv(self.csv, schema, keeps=mark.csv_bytes)
        except OSError as error:
            said = error.strerror or str(error)
            raise DataError(f"{self.folder}: its results cannot be continued: {said}") from None
        self._parts = _Parts(self.folder, schema, parts)
        self.n_rows = mark.n_rows


class _Csv:
    """The CSV file, with the length that it had after its last whole block of rows."""

    def __init__(self, path: Path, schema: Any, keeps: int = 0) -> None:
        """Open it; the first bytes of a file that is there may be kept."""
        from pyarrow import csv

        self._path = path
        self._file: IO[bytes] = path.open("r+b" if keeps else "w+b", buffering=0)
        if keeps:
            self._file.truncate(keeps)
            self._file.seek(keeps)
        options = csv.WriteOptions(include_header=not keeps)
        self._writer = csv.CSVWriter(_Unclosed(self._file), schema, write_options=options)
        self._whole = self._file.tell()

    def write(self, table: Any) -> None:
        for first in range(0, len(table), _BLOCK_ROWS):
            self._writer.write_table(table.slice(first, _BLOCK_ROWS))
            self._whole = self._file.tell()
        if not self.is_in_place():
            raise FileNotFoundError(errno.ENOENT, "removed during the run", str(self._path))

    def is_in_place(self) -> bool:
        """Whether the path still leads to the file that is written."""
        if self._file.closed:
            return self._path.exists()
        try:
            return os.path.samestat(os.stat(self._path), os.fstat(self._file.fileno()))
        except OSError:
            return False

    def keep_whole_rows(self) -> None:
        """Cut off what a write that failed left of its last row; a file that was ended has none."""
        if self._file.closed:
            return
        self._file.seek(self._whole)
        begun = self._file.read()
        self._file.truncate(self._whole + begun.rfind(b"\n") + 1)

    def write_again(self, path: Path) -> None:
        """Write a file that was removed again, from the descriptor that still holds its content."""
        self._file.seek(0)
        with path.open("wb") as copy:
            while block := self._file.read(2**20):
                copy.write(block)

    def sync(self) -> int:
        """Let it reach the disk; return its length."""
        os.fsync(self._file.fileno())
        return self._whole

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self._writer.close()
        self._file.close()

    def settle(self, path: Path) -> None:
        """Rename a file that was written under another name to its own."""
        if self._path != path:
            self._path.replace(path)
            self._path = path


class _Unclosed:
    """A file for pyarrow, which would close it with its writer, and takes a short write for a whole one."""

    closed = False

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file

    def write(self, data: bytes) -> int:
        rest = memoryview(data)
        while len(rest):
            rest = rest[self._file.write(rest) :]
        return len(data)

    def flush(self) -> None:
        """Nothing waits."""

    def tell(self) -> int:
        return self._file.tell()

    def close(self) -> None:
        """The file is closed by its owner."""


class _Parts:
    """Parquet files of some rows each, which appear under their names when they are complete."""

    def __init__(self, folder: Path, schema: Any, paths: list[Path] | None = None) -> None:
        self.schema = schema
        self._folder = folder
        self._tables: list[Any] = []
        self._paths = paths or []
        self._n_synced = 0
        self.is_durable = paths is not None
        self._begin = self._last = time.monotonic()

    def write(self, table: Any) -> None:
        """Take rows; a part is written when enough have come."""
        self._tables.append(table)
        now = time.monotonic()
        n_bytes = sum(t.nbytes for t in self._tables)
        if now - self._last > max(_PART_SECONDS, _PART_SHARE * (now - self._begin)) or n_bytes > _PART_BYTES:
            self.flush()
            self._last = time.monotonic()

    def is_empty(self) -> bool:
        """Whether it holds no row."""
        return not (self._paths or self._tables)

    def join(self, path: Path) -> None:
        """Write the last rows, and make one file of all parts; they go when it is complete."""
        import pyarrow as pa

        if self._paths:
            self.flush()
        with appearing(path, is_durable=self.is_durable) as new, _writer(new, self.schema) as writer:
            groups = _RowGroups(writer, self.schema)
            for part in self._paths:
                for batch in _batches(part):
                    groups.write(pa.Table.from_batches([batch], schema=self.schema))
            for table in self._tables:
                groups.write(table)
            groups.close()
        self._tables.clear()
        for part in self._paths:
            part.unlink()
        self._paths.clear()

    def sync(self) -> None:
        """Let all rows reach the disk, as parts, and the whole file at the end."""
        self.is_durable = True
        self.flush()
        for part in self._paths[self._n_synced :]:
            sync_file(part)
        self._n_synced = len(self._paths)

    def flush(self) -> None:
        """Write the rows that wait as a part."""
        if not self._tables:
            return
        import pyarrow as pa

        path = _part(self._folder, len(self._paths) + 1)
        with appearing(path) as new, _writer(new, self.schema) as writer:
            writer.write_table(pa.concat_tables(self._tables))
        self._paths.append(path)
        self._tables.clear()


class _RowGroups:
    """Writes row groups of one size, however many rows come at a time: the same rows, the same bytes."""

    def __init__(self, writer: Any, schema: Any) -> None:
        self._writer = writer
        self._size = max(1, min(_GROUP_ROWS, _GROUP_BYTES // (8 * len(schema))))
        self._waiting: list[Any] = []
        self._n_waiting = 0

    def write(self, table: Any) -> None:
        """Append rows."""
        while len(table):
            taken = table.slice(0, self._size - self._n_waiting)
            table = table.slice(len(taken))
            self._waiting.append(taken)
            self._n_waiting += len(taken)
            if self._n_waiting == self._size:
                self.close()

    def close(self) -> None:
        """Write the rows that wait as a group."""
        if not self._waiting:
            return
        import pyarrow as pa

        self._writer.write_table(pa.concat_tables(self._waiting).combine_chunks(), row_group_size=self._size)
        self._waiting.clear()
        self._n_waiting = 0


def existing(folder: Path) -> dict[str, str]:
    """Return the result files that are in a folder, by kind; Parquet may be there as parts."""
    found = {kind: folder / name for kind, name in (("csv", CSV), ("parquet", PARQUET))}
    there = {kind: str(path) for kind, path in found.items() if os.path.exists(path)}  # False if forbidden
    if "parquet" not in there and any(folder.glob(PARTS)):
        there["parquet"] = str(folder / PARTS)
    return there


def write_result(result: Result, folder: Path) -> ResultFiles:
    """Write a whole result; OSError if that cannot be, with the files that could be written in place."""
    files = ResultFiles(folder, at_once=True)
    try:
        files.write(result)
        files.close()
    except OSError:
        with contextlib.suppress(OSError):
            files.rescue()
        raise
    return files


def read_csv(path: Path) -> Result:
    """Read a CSV of this form back; units are not in it."""
    from pyarrow import csv

    table = csv.read_csv(str(path))
    names = tuple(table.column_names[1:])
    columns = [table.column(name).to_numpy() for name in table.column_names]
    values = np.column_stack(columns[1:]) if names else np.empty((len(columns[0]), 0))
    return Result(columns[0], names, ("",) * len(names), values)


def _part(folder: Path, number: int) -> Path:
    return folder / PARTS.replace("*", f"{number:05d}")


def _schema_of(path: Path) -> Any:
    import pyarrow as pa
    from pyarrow import parquet

    with parquet.ParquetFile(str(path)) as file:
        found = file.schema_arrow
    fields = [field.with_metadata({"unit": (field.metadata or {}).get(b"unit", b"")}) for field in found]
    return pa.schema(fields)


def _parts_up_to(n_rows: int, folder: Path) -> list[Path]:
    """
    Keep the first rows of what an earlier process left as parts, and nothing after them.

    A run that was interrupted has made one file of its parts: that becomes a part again.

    Raises:
        DataError: If there are fewer rows.
    """
    whole = folder / PARQUET
    if whole.exists():
        for part in folder.glob(PARTS):
            part.unlink()
        whole.replace(_part(folder, 1))
    kept: list[Path] = []
    left = n_rows
    for path in sorted(folder.glob(PARTS)):
        n = _n_rows(path) if left else 0
        if left == 0:
            path.unlink()
            continue
        if n > left:
            _cut(path, left)
        kept.append(path)
        left -= min(n, left)
    if left:
        raise DataError(f"{folder}: parts of {PARQUET}: got {n_rows - left} rows, expected {n_rows}")
    return kept


def _n_rows(path: Path) -> int:
    from pyarrow import parquet

    with parquet.ParquetFile(str(path)) as file:
        return int(file.metadata.num_rows)


def _cut(path: Path, n: int) -> None:
    """Keep the first n rows of a part."""
    import pyarrow as pa

    schema = _schema_of(path)
    with appearing(path, is_durable=True) as new, _writer(new, schema) as writer:
        groups = _RowGroups(writer, schema)
        for batch in _batches(path):
            groups.write(pa.Table.from_batches([batch.slice(0, n)], schema=schema))
            n -= min(n, len(batch))
        groups.close()


@contextlib.contextmanager
def _writer(path: Path, schema: Any) -> Iterator[Any]:
    from pyarrow import parquet

    with path.open("wb") as file, parquet.ParquetWriter(file, schema) as writer:
        yield writer


def _batches(path: Path) -> Iterator[Any]:
    from pyarrow import parquet

    with parquet.ParquetFile(str(path)) as file:
        yield from file.iter_batches()


def _parquet_of_csv(source: Path, target: Path, schema: Any) -> None:
    from pyarrow import csv

    types = csv.ConvertOptions(column_types={field.name: field.type for field in schema})
    reader = csv.open_csv(str(source), convert_options=types)
    with reader, appearing(target) as new, _writer(new, schema) as writer:
        for batch in reader:
            writer.write_batch(batch.replace_schema_metadata(None).cast(schema))


def _table(result: Result) -> Any:
    import pyarrow as pa

    columns = {"time": (result.time, "s")} | {
        name: (result.values[:, i], unit)
        for i, (name, unit) in enumerate(zip(result.names, result.units, strict=True))
    }
    fields = [pa.field(name, pa.float64(), metadata={"unit": unit}) for name, (_, unit) in columns.items()]
    return pa.table([_column(values) for values, _ in columns.values()], schema=pa.schema(fields))


def _column(values: Any) -> Any:
    """Return numbers, shape (n,), as an Arrow array; `pyarrow.array` would load pandas, if it is there."""
    import pyarrow as pa

    buffer = pa.py_buffer(np.ascontiguousarray(values, dtype=np.float64))
    return pa.Array.from_buffers(pa.float64(), len(values), [None, buffer])
