"""Tables and figures of a run carry their units."""

from __future__ import annotations

import pyarrow.parquet
import pytest

import dockloop as dl


@pytest.fixture(scope="module")
def run():
    return dl.load("low_frequency").run(stop_time=1.5)


def test_pandas_has_a_column_a_signal_and_the_units(run):
    pytest.importorskip("pandas")
    frame = run.to_pandas()

    assert frame.index.name == "time"
    assert frame["spacecraft.s_des"].tolist() == run["spacecraft.s_des"].tolist()
    assert frame.attrs["units"]["compensator.f_des"] == "N"
    assert frame.attrs["status"] == "completed"


def test_xarray_has_the_unit_of_each_variable(run):
    pytest.importorskip("xarray")
    data = run.to_xarray()

    assert data["compensator.f_des"].attrs["units"] == "N"
    assert data["time"].attrs["units"] == "s"
    assert data["spacecraft.s_des"].values.tolist() == run["spacecraft.s_des"].tolist()


def test_parquet_has_the_unit_of_each_column(run, tmp_path):
    schema = pyarrow.parquet.read_schema(run.save(tmp_path)["parquet"])

    assert schema.field("compensator.f_des").metadata[b"unit"] == b"N"


def test_a_figure_has_an_axis_a_unit(run):
    figure = run.plot("spacecraft.s_des", "compensator.f_des", "motion_simulator.s_act")

    assert [axis.get_ylabel() for axis in figure.axes] == ["[m]", "[N]"]
    assert [len(axis.lines) for axis in figure.axes] == [2, 1]
    assert figure.axes[-1].get_xlabel() == "time [s]"


def test_a_notebook_shows_a_figure_although_pyplot_is_not_loaded(run):
    assert run.plot("spacecraft.s_des")._repr_png_().startswith(b"\x89PNG")


def test_a_signal_that_is_not_there_is_told_what_is_near(run):
    with pytest.raises(KeyError, match=r"expected 'spacecraft\.s_des'"):
        run["spacecraft.s_dess"]
    with pytest.raises(KeyError):
        run.plot("spacecraft.sdes")


def test_reprs_say_what_a_notebook_shows(run):
    assert repr(run) == "<Run low_frequency: completed at t = 1.5 s, 27 signals>"
    assert "zeta" in run._repr_html_()
    assert "delay [steps]" in dl.load("low_frequency")._repr_html_()


def test_without_pandas_the_message_has_the_command(run, monkeypatch):
    import importlib.util

    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda n, *a: None if n == "pandas" else find(n, *a))

    with pytest.raises(
        dl.ConfigError, match=r"to_pandas: not installed, got no pandas, expected pip install"
    ):
        run.to_pandas()
