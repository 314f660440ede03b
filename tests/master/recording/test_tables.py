"""Files that are damaged or of another kind are refused with the file and the reason."""

from __future__ import annotations

import random
import signal
import subprocess
import zipfile

import numpy as np
import pytest
from scipy import io

from master.errors import DataError
from master.recording import mat_reader
from master.recording.tables import read_table

N = 400
SEED = 3


def whole(kind, folder):
    """Write a file of two columns."""
    path = folder / f"whole.{kind}"
    columns = {"t": np.arange(N) * 0.001, "f": np.sin(np.arange(N))}
    if kind == "npz":
        np.savez(path, **columns)
    elif kind == "mat":
        io.savemat(path, columns)
    elif kind == "parquet":
        import pyarrow as pa
        import pyarrow.parquet

        pa.parquet.write_table(pa.table(columns), path)
    else:
        rows = [f"{t!r},{f!r}" for t, f in zip(*(c.tolist() for c in columns.values()), strict=True)]
        path.write_text("\n".join(["t,f", *rows]) + "\n")
    return path


def damaged(content, chance):
    """Cut a file off, or change a few of its bytes, most of them where its structure is."""
    if chance.random() < 0.3:
        return content[: chance.randrange(len(content))]
    changed = bytearray(content)
    for _ in range(chance.choice([1, 1, 3, 10])):
        place = chance.choice([chance.randrange(len(content)), chance.randrange(min(400, len(content)))])
        changed[place] = chance.choice([0, 255, chance.randrange(256)])
    return bytes(changed)


def refusal(path):
    """Return the message of a refusal; None for a table."""
    try:
        read_table(path)
    except DataError as error:
        return str(error)
    return None


def complaint(path):
    """Return the message of a refusal, or the first fault of a table; None for a table without one."""
    return refusal(path) or next((texts[0] for texts in read_table(path).faults.values()), None)


@pytest.mark.parametrize(("kind", "count"), [("npz", 150), ("mat", 12), ("parquet", 150), ("csv", 150)])
def test_a_damaged_file_is_a_table_or_a_fault_of_one_line_that_names_it(kind, count, tmp_path):
    content, chance = whole(kind, tmp_path).read_bytes(), random.Random(SEED)
    path = tmp_path / f"damaged.{kind}"
    refusals = []
    for _ in range(count):
        path.write_bytes(damaged(content, chance))
        refusals.append(complaint(path))

    found = [text for text in refusals if text is not None]
    assert found
    assert all(text.startswith(f"{path}: ") and len(text.splitlines()) == 1 for text in found)


def test_a_mat_file_at_which_scipy_crashes_is_refused_and_the_next_is_read(tmp_path, monkeypatch):
    reader = tmp_path / "crash.py"
    reader.write_text("import os\nos.abort()\n")
    path = whole("mat", tmp_path)
    mat_reader.end_reader()
    with monkeypatch.context() as patched:
        patched.setattr(mat_reader, "__file__", str(reader))
        assert refusal(path) == f"{path}: cannot be read as a table: its content is damaged"

    assert refusal(path) is None


def test_mat_files_are_read_by_one_process(tmp_path, monkeypatch):
    path = whole("mat", tmp_path)
    mat_reader.end_reader()
    begun = []
    popen = subprocess.Popen
    monkeypatch.setattr(
        subprocess, "Popen", lambda *given, **named: begun.append(given) or popen(*given, **named)
    )

    assert [refusal(path) for _ in range(3)] == [None] * 3
    assert len(begun) == 1


def test_a_reader_that_was_ended_between_two_files_is_replaced(tmp_path):
    path = whole("mat", tmp_path)
    assert refusal(path) is None
    reader = mat_reader._reader()
    reader.kill()
    reader.wait()

    assert refusal(path) is None


def test_an_interrupt_of_the_terminal_does_not_end_the_reader(tmp_path):
    path = whole("mat", tmp_path)
    assert refusal(path) is None
    reader = mat_reader._reader()
    reader.send_signal(signal.SIGINT)

    assert refusal(path) is None
    assert mat_reader._reader() is reader


@pytest.mark.parametrize("kind", ["npz", "mat", "parquet"])
@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"t,f\n0,1\n", b"MATLAB 5.0 MAT-file"])
def test_a_file_of_another_kind_is_refused(kind, content, tmp_path):
    path = tmp_path / f"other.{kind}"
    path.write_bytes(content)

    with pytest.raises(DataError, match="cannot be read as a table: "):
        read_table(path)


def test_an_array_alone_is_no_npz(tmp_path):
    np.save(tmp_path / "one.npy", np.arange(N))
    path = (tmp_path / "one.npy").rename(tmp_path / "one.npz")

    with pytest.raises(DataError, match="cannot be read as a table: File is not a zip file"):
        read_table(path)


def test_an_npz_whose_array_got_shorter_in_its_header_is_damaged(tmp_path):
    path = whole("npz", tmp_path)
    path.write_bytes(path.read_bytes().replace(b"(400,)", b"(100,)"))

    with pytest.raises(DataError, match=r"t\.npy is damaged"):
        read_table(path)


def test_columns_of_complex_numbers_are_refused(tmp_path):
    path = tmp_path / "complex.npz"
    np.savez(path, table=np.ones((N, 2)) * 1j, t=np.arange(N) * 1j)

    with pytest.raises(DataError, match="array 'table': got values of type complex128, expected numbers"):
        read_table(path, "table")
    assert read_table(path).faults["t"] == [
        f"{path}: column 't': got values of type complex128, expected numbers"
    ]


@pytest.mark.parametrize("cell", ["1_000", "\u0661", "1;5", "true", "0x1F"])
def test_a_cell_of_a_csv_that_is_no_plain_number_is_a_fault(cell, tmp_path):
    path = tmp_path / "cells.csv"
    path.write_text(f't\n0\n"{cell}"\n', encoding="utf-8")

    assert read_table(path).faults["t"] == [f"{path}: row 3, column 't': got {cell!r}, expected a number"]


@pytest.mark.parametrize("value", ["4", "word"])
def test_blank_lines_of_a_csv_are_no_rows(value, tmp_path):
    path = tmp_path / "blank.csv"
    path.write_text(f"t,F\n0,1\n\n1,{value}\n\n")
    table = read_table(path)

    assert table.columns["t"].tolist() == [0.0, 1.0]
    assert table.faults.get("F", []) == (
        [] if value == "4" else [f"{path}: row 4, column 'F': got 'word', expected a number"]
    )


def test_integers_of_a_csv_are_rounded_once(tmp_path):
    path = tmp_path / "large.csv"
    path.write_text("t\n9007199254740993\n99999999999999999999\n")

    assert read_table(path).columns["t"].tolist() == [9007199254740992.0, 1e20]


def test_a_csv_with_nul_bytes_or_a_huge_cell_is_refused(tmp_path):
    path = tmp_path / "strange.csv"
    for content in ("t\n" + '"' + "x" * 200_000, "t\n\0\n"):
        path.write_text(content)
        text = refusal(path)
        assert "cannot be read as a table: " in text if text else read_table(path).faults


@pytest.mark.parametrize("name", ["x" * 300, "nul\0", "\ud800"])
def test_a_name_that_no_file_may_have_is_no_file(name, tmp_path):
    with pytest.raises(DataError, match="no such file"):
        read_table(tmp_path / f"{name}.csv")


def test_a_member_of_an_npz_that_is_no_array_is_refused(tmp_path):
    path = tmp_path / "text.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("t.npy", "no array")

    with pytest.raises(DataError, match="cannot be read as a table: "):
        read_table(path)
