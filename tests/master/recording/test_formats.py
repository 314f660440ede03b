"""Files of many formats, written by other libraries, are read right or refused with what to write."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest

from master.errors import DataError
from master.recording.tables import FORMATS, read_table

N = 250
T = np.round(np.arange(N) * 0.004, 4)
X = np.round(np.sin(T), 4)


def text(tmp_path, content, name="run.csv", encoding="utf-8"):
    path = tmp_path / name
    path.write_bytes(content.encode(encoding))
    return read_table(path)


def rows(separator=",", decimal=".", end=""):
    lines = (f"{t:.4f}{separator}{x:.4f}{end}" for t, x in zip(T, X, strict=True))
    return "\n".join(lines).replace(".", decimal) + "\n"


def refusal(path):
    """The message of a refusal, or the first fault of a table."""
    try:
        table = read_table(path)
    except DataError as error:
        return str(error)
    return next(iter(table.faults.values()))[0]


LAYOUTS = {
    "semicolons": "t;x\n" + rows(";"),
    "semicolons and decimal commas": "t;x\n" + rows(";", ","),
    "tabs": "t\tx\n" + rows("\t"),
    "tabs and decimal commas": "t\tx\n" + rows("\t", ","),
    "spaces": "t x\n" + rows("   "),
    "spaces and decimal commas": "t x\n" + rows(" ", ","),
    "spaces after commas": "t, x\n" + rows(", "),
    "trailing commas": "t,x,\n" + rows(end=","),
    "trailing commas in the rows alone": "t,x\n" + rows(end=","),
    "a preamble": "Rig 7, hall B\nOperator: Jo\n\nt,x\n" + rows(),
    "a preamble of names and values": "Rate;250\nOperator;Jo\nt;x\n" + rows(";"),
    "a row of units": "t,x\ns,mm\n" + rows(),
    "units in brackets": "t;x\n[s];[mm]\n" + rows(";", ","),
    "comments": "# made by a logger\nt,x\n# begin\n" + rows() + "# end\n",
    "names in a comment": "% t x\n" + rows(" "),
    "quotes": '"t";"x"\n' + rows(";"),
    "lines of Windows": ("t;x\n" + rows(";")).replace("\n", "\r\n"),
    "a column of words": "t,x,state\n" + rows(end=",run"),
    "commas in quotes": "t,x\n"
    + "".join(f'"{t:.4f}","{x:.4f}"\n'.replace(".", ",") for t, x in zip(T, X, strict=True)),
}


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_text_of_columns_is_read_by_what_its_rows_show(name, tmp_path):
    table = text(tmp_path, LAYOUTS[name], "run.txt")

    assert not {"t", "x", ""} & set(table.faults)
    np.testing.assert_array_equal(table.columns["t"], T)
    np.testing.assert_array_equal(table.columns["x"], X)


def test_without_a_header_columns_are_numbered(tmp_path):
    table = text(tmp_path, rows("\t"))

    assert list(table.columns) == ["0", "1"]
    assert table.columns["1"].tolist() == X.tolist()


def test_two_header_rows_are_joined_where_neither_names_each_column(tmp_path):
    table = text(tmp_path, "Rig,,Cell,\ntime,x,time,x\n" + "".join(f"{i}.5,1.5,2.5,3.5\n" for i in range(9)))

    assert list(table.columns) == ["Rig time", "Rig x", "Cell time", "Cell x"]


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16", "utf-8-sig"])
def test_a_name_in_another_encoding_is_a_name(encoding, tmp_path):
    assert "Größe" in text(tmp_path, "t;Größe\n" + rows(";"), encoding=encoding).columns


def test_units_of_a_second_row_are_kept(tmp_path):
    assert text(tmp_path, LAYOUTS["a row of units"]).units == {"t": "s", "x": "mm"}


@pytest.mark.parametrize(
    ("cells", "values"),
    [
        (["1.234,5", "2,5"], [1234.5, 2.5]),
        (["1,234.5", "2.5"], [1234.5, 2.5]),
        (["0,125", "1,234"], [0.125, 1.234]),
        (["1,234,567", "1,234"], [1234567.0, 1234.0]),
        (["1.234", "2.345"], [1.234, 2.345]),
    ],
)
def test_a_sign_that_a_column_proves_is_taken(cells, values, tmp_path):
    table = text(tmp_path, "a;b\n" + "".join(f"{cell};5\n" for cell in cells))

    assert not table.faults
    assert table.columns["a"].tolist() == values


@pytest.mark.parametrize(
    "content",
    ["a;b\n1,234;5\n2,345;6\n", "a;b\n1.234;0,5\n2.345;0,5\n", "a;b\n1,234;0.5\n", 'a,b\n"1,234",5\n'],
)
def test_a_comma_that_may_be_decimal_or_between_thousands_is_refused_in_its_column_alone(content, tmp_path):
    table = text(tmp_path, content)

    assert list(table.faults) == ["a"]
    assert "expected a number whose decimal sign the column shows" in table.faults["a"][0]
    assert np.isnan(table.columns["a"]).all()


@pytest.mark.parametrize("content", ["0,1\n0.5,1\n", "0,001,1\n0,002,2\n"])
def test_a_first_line_that_may_be_names_or_cut_numbers_is_refused(content, tmp_path):
    with pytest.raises(DataError, match="expected a header"):
        text(tmp_path, content)


def test_numbers_cut_apart_at_their_decimal_comma_are_too_many_cells(tmp_path):
    table = text(tmp_path, "t,x\n0,5,1,5\n1,5,2,5\n")

    assert table.faults[""][0].endswith("row 2: got 4 cells, expected 2")


def test_a_word_below_the_name_of_one_column_is_no_second_header(tmp_path):
    assert "got 'word', expected a number" in text(tmp_path, "t\nword\n1\n2\n3\n").faults["t"][0]


def test_dates_are_seconds_since_the_first_to_the_nanosecond(tmp_path):
    lines = [f"2026-03-29 23:59:59.{i:03d}000001;{i}.5\n" for i in range(998, 1000)]
    table = text(tmp_path, "t;x\n" + "".join(lines) + "2026-03-30T00:00:00,000000001;1.5\n")

    assert table.dates == {"t"}
    assert table.columns["t"].tolist() == [0.0, 0.001, 0.002]


def test_dates_of_two_kinds_are_refused(tmp_path):
    assert text(tmp_path, "t;x\n2026-03-29 23:59:59Z;1\n2026-03-29 23:59:59;1\n").faults["t"]


def test_json_rows_lines_and_columns_are_the_same_table(tmp_path):
    given = [{"t": t, "rig": {"x": x}, "state": "run"} for t, x in zip(T.tolist(), X.tolist(), strict=True)]
    contents = {
        "rows.json": json.dumps(given),
        "wrapped.json": json.dumps({"made": "today", "data": given}),
        "lines.jsonl": "\n".join(map(json.dumps, given)),
        "columns.json": json.dumps({"t": T.tolist(), "rig.x": X.tolist()}),
    }
    for name, content in contents.items():
        table = text(tmp_path, content, name)
        assert table.columns["t"].tolist() == T.tolist()
        assert table.columns["rig.x"].tolist() == X.tolist()
        assert not {"t", "rig.x"} & set(table.faults)


def test_a_null_or_a_truth_value_in_json_is_no_number(tmp_path):
    table = text(tmp_path, '[{"t": 0, "x": null}, {"t": 1, "x": true}]', "run.json")

    assert [line.partition("got ")[2] for line in table.faults["x"]] == [
        "None, expected a number",
        "True, expected a number",
    ]


def test_structures_of_a_mat_file_are_columns_by_their_fields(tmp_path):
    from scipy import io

    points = np.array([(t, x) for t, x in zip(T, X, strict=True)], dtype=[("t", "O"), ("x", "O")])
    io.savemat(tmp_path / "run.mat", {"data": {"t": T, "rig": {"x": X}}, "points": points})
    columns = read_table(tmp_path / "run.mat").columns

    for name in ("data.t", "points.t"):
        assert columns[name].tolist() == T.tolist()
    for name in ("data.rig.x", "points.x"):
        assert columns[name].tolist() == X.tolist()


def test_a_mat_file_of_version_7_3_is_read_as_matlab_shows_it(tmp_path):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "run.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values, kind in (("data/t", T[:, None].T, "double"), ("word", [[104, 105]], "char")):
            file[name] = values
            file[name].attrs["MATLAB_class"] = np.bytes_(kind)
        file["table"] = np.column_stack([T, X]).T
        file["table"].attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(512))

    assert list(read_table(path).columns) == ["data.t"]
    assert read_table(path, "table").columns["1"].tolist() == X.tolist()


def test_hdf5_gives_folders_compounds_scaled_and_missing_values(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["rig/x"] = X
        file["rig/x"].attrs["units"] = "mm"
        file["counts"] = np.array([1, 2, -9], dtype=np.int16)
        file["counts"].attrs.update({"scale_factor": 0.5, "add_offset": 10.0, "_FillValue": np.int16(-9)})
        file["both"] = np.array([*zip(T, X, strict=True)], dtype=[("t", float), ("x", float)])
    table = read_table(tmp_path / "run.h5")

    assert table.columns["rig/x"].tolist() == X.tolist()
    assert table.units == {"rig/x": "mm"}
    assert table.columns["both.t"].tolist() == T.tolist()
    np.testing.assert_array_equal(table.columns["counts"], [10.5, 11.0, np.nan])


def test_an_mdf_file_gives_physical_values_by_the_clock_of_their_group(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF(version="4.10") as file:
        conversion = {"a": 0.01, "b": 5.0}
        counts = np.arange(N, dtype=np.int16)
        file.append([asammdf.Signal(counts, T, name="F", unit="N", conversion=conversion)])
        file.append([asammdf.Signal(X[:100], 2.0 * T[:100], name="x", unit="mm")])
        path = file.save(tmp_path / "run.mf4")
    table = read_table(path)

    np.testing.assert_allclose(table.columns["F"], 0.01 * counts + 5.0, rtol=1e-15)
    assert table.columns["0.time"].tolist() == T.tolist()
    assert table.columns["1.time"].tolist() == (2.0 * T[:100]).tolist()
    assert table.units["x"] == "mm"


def test_a_tdms_file_gives_channels_their_units_and_their_clock(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    properties = {"unit_string": "mm", "wf_increment": 0.004, "wf_start_offset": 0.0}
    with nptdms.TdmsWriter(tmp_path / "run.tdms") as writer:
        writer.write_segment([nptdms.ChannelObject("rig", "x", X, properties)])
        writer.write_segment([nptdms.ChannelObject("cell", "x", 2.0 * X, {})])
    table = read_table(tmp_path / "run.tdms")

    assert table.columns["rig/x"].tolist() == X.tolist()
    assert table.columns["cell/x"].tolist() == (2.0 * X).tolist()
    np.testing.assert_allclose(table.columns["rig/x.time"], T, rtol=0.0, atol=1e-12)
    assert table.units["rig/x"] == "mm"


@pytest.mark.parametrize("version", [1, 2])
def test_a_bag_gives_the_numbers_of_its_messages_in_seconds_since_its_begin(version, tmp_path):
    pytest.importorskip("rosbags")
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if version == 1 else Stores.ROS2_HUMBLE)
    kind = store.types["sensor_msgs/msg/JointState"]
    header = store.types["std_msgs/msg/Header"]
    stamp = store.types["builtin_interfaces/msg/Time"]
    path = tmp_path / ("run.bag" if version == 1 else "run")
    begin = 1_700_000_000
    with Writer1(path) if version == 1 else Writer2(path, version=8) as writer:
        joint = writer.add_connection("/joint", kind.__msgtype__, typestore=store)
        pack = store.serialize_ros1 if version == 1 else store.serialize_cdr
        for i in range(20):
            own = {"seq": i} if version == 1 else {}
            head = header(stamp=stamp(sec=begin, nanosec=i * 4_000_000), frame_id="", **own)
            values = np.array([X[i]])
            message = kind(header=head, name=["a"], position=values, velocity=-values, effort=values[:0])
            writer.write(joint, begin * 10**9 + i * 4_000_000, pack(message, kind.__msgtype__))
    columns = read_table(path).columns

    assert columns["/joint/position.0"].tolist() == X[:20].tolist()
    assert columns["/joint/velocity.0"].tolist() == (-X[:20]).tolist()
    for name in ("/joint/time", "/joint/header.stamp"):
        np.testing.assert_allclose(columns[name], T[:20], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("ending", "module", "package"),
    [("h5", "h5py", "h5py"), ("mf4", "asammdf", "asammdf"), ("tdms", "nptdms", "npTDMS")],
)
def test_a_format_whose_library_is_absent_says_which_and_how_to_install_it(
    ending, module, package, tmp_path, monkeypatch
):
    monkeypatch.setitem(sys.modules, module, None)
    path = tmp_path / f"run.{ending}"
    path.write_bytes(b"anything")

    with pytest.raises(DataError) as caught:
        read_table(path)
    said = f"package {package}: not installed, got none, expected pip install 'dockloop[data]'"
    assert str(caught.value) == f"{path}: {said}"


@pytest.mark.parametrize("ending", sorted(FORMATS))
def test_noise_of_any_ending_is_a_fault_of_one_line(ending, tmp_path):
    path = tmp_path / f"noise{ending}"
    path.write_bytes(bytes(range(256)))

    assert len(refusal(path).splitlines()) == 1
