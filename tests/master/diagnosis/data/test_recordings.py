from __future__ import annotations

import numpy as np
import pytest
from scipy import io

from master.diagnosis.data.clock import ClockRules
from master.diagnosis.data.recordings import Column, Rules, read
from master.errors import DataError
from master.fmi.unit_names import unit

N = 400
TIME = Column("time", "ms")
COLUMNS = {
    "s": Column("way", "mm", sign=-1),
    "v": Column("speed", "in/s"),
    "f": Column("force", "kN", scale=2.0),
}


def table(**changed):
    t = np.arange(N) * 0.5
    way = np.sin(0.1 * np.arange(N))
    speed = -np.gradient(way, t) / 25.4 * 1e3
    return {"time": t, "way": way, "speed": speed, "force": np.ones(N)} | changed


def csv(folder, **changed):
    columns = table(**changed)
    rows = [",".join(columns), *(",".join(map(str, row)) for row in zip(*columns.values(), strict=True))]
    path = folder / "run.csv"
    path.write_text("\n".join(rows) + "\n")
    return path


def faults(path, *, period=None, **rules):
    with pytest.raises(DataError) as caught:
        read(path, TIME, COLUMNS, rules=Rules(clock=ClockRules(period=period), **rules))
    return str(caught.value).replace(str(path), "run").splitlines()


def write(kind, folder, **changed):
    path = folder / f"run.{kind}"
    if kind == "npz":
        np.savez(path, **table(**changed))
    elif kind == "mat":
        io.savemat(path, table(**changed))
    elif kind == "parquet":
        import pyarrow
        import pyarrow.parquet

        pyarrow.parquet.write_table(pyarrow.table(table(**changed)), path)
    else:
        return csv(folder, **changed)
    return path


@pytest.mark.parametrize("kind", ["csv", "npz", "mat", "parquet"])
def test_columns_become_signals_in_si(kind, tmp_path):
    found = read(write(kind, tmp_path), TIME, COLUMNS, rules=Rules(rates={"s": "v"}))

    assert len(found) == N
    assert found.period == pytest.approx(0.5e-3)
    assert found["s"][10] == pytest.approx(-1e-3 * np.sin(1.0))
    assert found["v"][10] == pytest.approx(table()["speed"][10] * 0.0254)
    assert found["f"][0] == 2000.0


def test_named_array_has_its_own_columns(tmp_path):
    path = tmp_path / "all.npz"
    np.savez(path, one=np.column_stack(list(table().values())), columns=np.array(list(table())))

    assert read(path, TIME, COLUMNS, array="one").name == "one"


def test_cells_that_are_no_numbers_are_named_by_row_and_column(tmp_path):
    way = table()["way"].astype(object)
    way[3], way[7] = "lost", "nan"

    assert faults(csv(tmp_path, way=way)) == ["run: row 5, column 'way': got 'lost', expected a number"]


def test_nan_is_named_by_row_and_column_and_counted(tmp_path):
    force = np.ones(N)
    force[10:20] = np.nan

    found = faults(csv(tmp_path, force=force))
    assert found[0] == "run: row 12, column 'force': got nan, expected a number"
    assert found[-1] == "... and 5 more in column 'force'"


def test_time_that_goes_back_is_named_by_row(tmp_path):
    t = table()["time"]
    t[100] = t[98]

    assert faults(csv(tmp_path, time=t)) == [
        "run: row 102: time goes from 0.0495 to 0.049 s, expected it to grow"
    ]


def test_gap_and_jitter_are_named_by_row(tmp_path):
    t = table()["time"]
    t[100:] += 5.0
    t[200] += 0.1

    assert faults(csv(tmp_path, time=t)) == [
        "run: row 102: gap, got a step of 0.0055 s after t=0.0495 s, expected 0.0005 s",
        "run: row 202: jitter, got a step of 0.0006 s after t=0.1045 s, expected 0.0005 s",
        "run: row 203: jitter, got a step of 0.0004 s after t=0.1051 s, expected 0.0005 s",
    ]


def test_clock_offset_and_wrong_period_are_reported(tmp_path):
    found = faults(csv(tmp_path, time=table()["time"] + 30.0), period=1e-3)

    assert found[0].startswith("run: clock offset, got a first time of 0.03 s, expected 0 s")
    assert found[1] == "run: sampling period, got 0.0005 s, expected 0.001 s"


def test_wrong_unit_of_a_rate_is_reported(tmp_path):
    (found,) = faults(csv(tmp_path, speed=table()["speed"] * 25.4), rates={"s": "v"})

    assert found.startswith("run: v is not the rate of s: its integral is 25.")
    assert found.endswith("of its change, expected about 1 (wrong unit, scale or sign?)")


def test_too_few_samples_are_reported(tmp_path):
    assert faults(csv(tmp_path), fewest=1000) == ["run: too few samples, got 400, expected at least 1000"]


def test_wrong_columns_and_units_are_reported_together(tmp_path):
    with pytest.raises(DataError) as caught:
        read(csv(tmp_path), Column("t", "m"), {"s": Column("way", "furlong")})

    found = str(caught.value).splitlines()
    assert len(found) == 3
    assert "column for time: got 't', expected one of ['time', 'way'" in found[0]
    assert "got the unit 'm', expected a time" in found[1]
    assert "unknown symbol, got 'furlong'" in found[2]


def test_steps_back_hide_no_gap(tmp_path):
    t = table()["time"]
    t[200:] += 5.0
    t[100] = t[98]

    found = faults(csv(tmp_path, time=t))
    assert found[0].startswith("run: row 102: time goes from 0.0495 to 0.049 s")
    assert any(line.startswith("run: row 202: gap, got a step of 0.0055 s") for line in found)


def test_tables_of_other_programs_are_refused_with_a_hint(tmp_path):
    path = tmp_path / "run.csv"
    for text, message in (
        ("time;way\n1,234;1\n", "expected one of ['time', 'way']"),
        ("time,way,way,speed,force\n0,1,1,1,1\n", "column 'way' is there 2 times, expected once"),
    ):
        path.write_text(text)
        assert any(message in line for line in faults(path))


def test_byte_order_mark_is_no_part_of_a_name(tmp_path):
    path = csv(tmp_path)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())

    assert len(read(path, TIME, COLUMNS)) == N


@pytest.mark.parametrize("kind", ["npz", "mat", "parquet"])
def test_cells_of_binary_tables_are_named_too(kind, tmp_path):
    force, way = np.ones(N), table()["way"].astype(str)
    force[3] = np.inf

    found = faults(write(kind, tmp_path, way=way, force=force))
    assert found[0].startswith("run: column 'way': got values of type")
    assert found[1] == "run: row 3, column 'force': got inf, expected a number"


def test_broken_binary_files_are_refused(tmp_path):
    for kind in ("npz", "mat", "parquet"):
        path = tmp_path / f"run.{kind}"
        path.write_bytes(b"no such format")
        assert faults(path)[0].startswith("run: cannot be read as a table: ")


def test_array_without_names_for_all_columns_is_refused(tmp_path):
    path = tmp_path / "run.npz"
    np.savez(path, one=np.ones((N, 4)), columns=np.array(["time", "way"]))

    with pytest.raises(DataError, match="got 2 names, expected 4"):
        read(path, TIME, COLUMNS, array="one")
    np.savez(path, one=np.ones((N, 4)))
    with pytest.raises(DataError, match="no columns, expected the name of an array"):
        read(path, TIME, COLUMNS)


@pytest.mark.parametrize(
    ("name", "factor"), [("\u00b5m", 1e-6), ("m/s\u00b2", 1.0), ("N*s/m", 1.0), ("MPa", 1e6)]
)
def test_units_are_read_as_people_write_them(name, factor):
    assert unit(name).factor == pytest.approx(factor)


def test_lengths_must_agree(tmp_path):
    path = tmp_path / "run.npz"
    np.savez(path, **table(force=np.ones(3)))

    assert "columns have different lengths" in faults(path)[0]


def test_unknown_kind_of_file_is_refused(tmp_path):
    with pytest.raises(DataError, match=r"got '.xls', expected one of"):
        read(tmp_path / "run.xls", TIME, COLUMNS)
