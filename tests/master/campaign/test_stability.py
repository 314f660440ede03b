"""The stability map of a campaign: medians of runs, and the eigenvalues at the values of the cells."""

from __future__ import annotations

import numpy as np
import pytest

from master.analysis.closed_loop.linearise import Linearisation, without_reference
from master.analysis.measures.poles import fastest
from master.campaign import stability as of_campaign
from master.campaign.plan import make_plan
from master.campaign.systems import Systems

pytestmark = pytest.mark.slow

CAMPAIGN = """\
system: experiment
variant: cfdc_fmdc
vary:
  spacecraft.m_s: {uniform: [500, 900]}
  force_sensor.T_f: {uniform: [8, 14], unit: ms}
  contact.k_p: {values: [30000, 40000, 50000]}
  contact.k_m: {same_as: contact.k_p, factor: 3.7}
design: {method: latin_hypercube, size: 90, seed: 1}
keep: {metrics: all}
"""


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    path = tmp_path_factory.mktemp("campaign") / "campaign.yaml"
    path.write_text(CAMPAIGN)
    return make_plan(path)


@pytest.fixture
def columns(plan):
    """Runs that grow by 1/s for each ms of lag over 11, and by 1/s for 1000 kg."""
    found = {column.key: column.values for column in plan.sample.columns}
    rate = 1e3 * (found["force_sensor.T_f"] - 0.011) + 1e-3 * found["spacecraft.m_s"]
    found |= {"growth_per_cycle": np.exp(rate / 2.0), "frequency": np.full(90, 2.0), "zeta": -0.1 * rate}
    return found | {"status": np.full(90, "completed", dtype=object)}


@pytest.mark.long
def test_the_maps_are_the_growth_of_the_runs_and_of_the_system_with_the_values_of_each_cell(
    plan, columns, monkeypatch
):
    maps = []
    monkeypatch.setattr(of_campaign, "map_chart", lambda found, title: maps.append((found, title)))
    of_campaign.stability(plan, columns)
    [(runs, _), (eigenvalues, title)] = maps

    assert title == "from eigenvalues"
    assert runs.x.signals == ("force_sensor.T_f",)  # the growth depends on it most
    expected = 1e3 * (runs.x.values - 0.011) + 1e-3 * runs.y.values[:, None]
    assert np.abs(runs.growth - expected).max() < 0.5  # a cell is 2 ms wide
    row = {"spacecraft.m_s": runs.y.values[2], "force_sensor.T_f": runs.x.values[0]}
    row |= {"contact.k_p": 40000.0, "contact.k_m": 3.7 * 40000.0}
    alone = Systems(plan.varied).experiment(row)
    pole = fastest(Linearisation(without_reference(alone)).coupled(), neutral=1e-7)
    assert eigenvalues.growth[2, 0] == pytest.approx(pole.growth, rel=1e-9)
    assert eigenvalues.damping[2, 0] == pytest.approx(pole.zeta, rel=1e-9)


def test_of_a_campaign_whose_fmus_crash_no_fmu_is_loaded_for_eigenvalues(plan, columns):
    columns["status"][7] = "crashed"
    found = of_campaign.stability(plan, columns)

    assert [chart.title for chart in found.charts] == ["from the runs"]
    assert found.note == "No eigenvalues: an FMU of this campaign ends its process or hangs."


def test_without_growth_or_with_one_value_there_is_no_map(plan, columns):
    assert of_campaign.stability(plan, {**columns, "growth_per_cycle": np.full(90, np.nan)}) is None
    del columns["frequency"]
    assert of_campaign.stability(plan, columns) is None
