"""A campaign in Python: the runs of a mass without a force, which stays where it is, as one table."""

from __future__ import annotations

import math

import numpy as np
import pytest

import dockloop as dl
from master.errors import ConfigError

STEPS = 50
H = 0.001  # s


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """A mass without a force: 2 masses x 3 places, 50 ms."""
    folder = tmp_path_factory.mktemp("campaign")
    (folder / "resting.yaml").write_text(
        f"name: resting\nstep_size: {H}\nstop_time: {STEPS * H}\n"
        "fmus:\n  mass: {source: spacecraft, parameters: {m_s: 100}}\n",
        encoding="utf-8",
    )
    (folder / "campaign.yaml").write_text(
        "name: masses\nsystem: resting.yaml\n"
        "vary:\n  mass.m_s: {values: [100, 200]}\n  mass.s_des: {values: [0.0, 0.5, 1.0]}\n"
        "design: {method: grid}\n"
        "keep: {measures: {last: {final: mass.s_des}, largest: {largest: mass.s_des}}}\n",
        encoding="utf-8",
    )
    return dl.sweep(folder / "campaign.yaml", folder / "out", workers=1)


def test_each_run_is_a_row_with_its_inputs_and_numbers(campaign):
    assert len(campaign) == 6
    assert campaign.statuses == {"completed": 6}
    assert sorted(zip(campaign["mass.m_s"], campaign["mass.s_des"], strict=True)) == [
        (m, s) for m in (100.0, 200.0) for s in (0.0, 0.5, 1.0)
    ]
    assert np.allclose(campaign["last"], campaign["mass.s_des"], atol=1e-12)  # no force: it stays
    assert campaign.page is not None
    assert campaign.page.is_file()
    assert (campaign.units["mass.m_s"], campaign.units["last"]) == ("kg", "m")


def test_answers_are_the_description_of_the_numbers(campaign):
    found = campaign.answers()

    assert found["diverged"]["value"] == 0.0
    assert found["numbers"]["last"]["n"] == 6
    assert found["numbers"]["last"]["mean"] == pytest.approx(0.5)
    assert found["numbers"]["last"]["deviation"] == pytest.approx(math.sqrt(0.2))
    assert "sobol" not in found


def test_a_data_frame_has_a_row_a_run_with_units(campaign):
    frame = campaign.to_pandas()

    assert frame.index.name == "run"
    assert len(frame) == 6
    assert frame["last"].max() == pytest.approx(1.0)
    assert frame.attrs["units"]["mass.s_des"] == "m"


def test_a_dataset_of_a_whole_grid_has_its_axes(campaign):
    dataset = campaign.to_xarray()

    assert dict(dataset.sizes) == {"mass.m_s": 2, "mass.s_des": 3}
    assert dataset["last"].sel({"mass.m_s": 200.0, "mass.s_des": 0.5}).item() == pytest.approx(0.5)
    assert dataset["last"].attrs == {"unit": "m"}
    assert dataset.attrs == {"name": "masses"}


def test_it_is_shown_with_its_statuses(campaign):
    assert repr(campaign) == "<Campaign masses: 6 runs, 6 completed>"
    assert "<td>completed</td><td>6</td>" in campaign._repr_html_()


def test_a_column_that_is_not_there_is_refused_with_those_that_are(campaign):
    with pytest.raises(KeyError, match=r"no such column, got \['lost'\], expected one of .*last"):
        campaign["lost"]


def test_a_campaign_may_be_a_dict_and_its_faults_are_said_together():
    content = {
        "system": "low_frequency",
        "vary": {"force_sensor.T_f": {"uniform": [8, 12], "unit": "ms"}, "spacecraft.m_x": {"values": [1]}},
        "design": {"method": "sobol", "size": 2, "seed": 1},
    }

    with pytest.raises(ConfigError, match=r"m_x"):
        dl.sweep(content)


def test_a_dict_is_run_into_a_folder_of_its_own():
    content = {
        "system": "low_frequency",
        "stop_time": 0.02,
        "vary": {"force_sensor.T_f": {"uniform": [8, 12], "unit": "ms"}},
        "design": {"method": "sobol", "size": 2, "seed": 1},
    }
    found = dl.sweep(content, workers=1)
    dataset = found.to_xarray()

    assert found.folder.is_dir()
    assert dict(dataset.sizes) == {"run": 2}
    assert found.units["force_sensor.T_f"] == "s"
    assert np.all((found["force_sensor.T_f"] >= 0.008) & (found["force_sensor.T_f"] <= 0.012))
