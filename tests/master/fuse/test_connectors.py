"""Inputs and outputs of the system itself are those of the fused FMU."""

from __future__ import annotations

import numpy as np
import pytest

from master.fmi.description_reader import read_description
from tests.master.fuse.fused_run import Host, assert_same_bits, exported, prepared
from tests.master.fuse.systems import MEMBERS, loop

pytestmark = [pytest.mark.slow, pytest.mark.long]

H = 1e-3


def system(start: float | None = 0.5, **changes) -> dict:
    """The loop with a second spacecraft whose force is an input of the system in kN."""
    data = loop(MEMBERS, free={"source": "spacecraft", "parameters": {"m_s": 100}}, stop=0.02)
    data["coupling"]["order"] = [*MEMBERS, "free"]
    force = {"kind": "input", "type": "real", "unit": "kN"}
    data["connectors"] = {
        "whole.force": force if start is None else force | {"start": start},
        "whole.way": {"kind": "output", "type": "real", "unit": "mm"},
        "whole.speed": {"kind": "output", "type": "real", "unit": "m/s"},
        "whole.passed": {"kind": "output", "type": "real", "unit": "N"},
    }
    data["connections"] += [
        {"from": "whole.force", "to": "free.f"},
        {"from": "free.s_des", "to": "whole.way"},
        {"from": "free.v_des", "to": "whole.speed"},
        {"from": "whole.force", "to": "whole.passed"},
    ]
    return data | changes


@pytest.fixture(scope="module", params=["2.0", "3.0"])
def fused(tmp_path_factory, request):
    folder = tmp_path_factory.mktemp("connectors")
    experiment = prepared(folder, system())
    return experiment, exported(experiment, folder, request.param)


def test_outputs_of_the_system_have_the_bits_of_run(fused):
    assert_same_bits(*fused)


def test_its_connectors_have_the_units_of_the_system_and_what_they_lead_to_is_only_shown(fused):
    found = read_description(fused[1]).by_name

    assert [(found[n].causality, found[n].unit_name) for n in ("whole.force", "whole.way", "free.f")] == [
        ("input", "kN"),
        ("output", "mm"),
        ("local", "N"),
    ]
    assert found["whole.force"].start_value == 0.5


def test_a_host_drives_the_system_by_its_input(fused):
    host = Host(fused[1]).start(whole__force=2.0)
    rows = host.rows(["free.v_des", "whole.speed", "free.s_des", "whole.way"], 10, H)
    host.set("whole.force", -1.0)
    host.fmu.doStep(10 * H, H)
    before, after = rows[-1, 0], host.get("free.v_des")[0]
    told = host.get("whole.passed", "free.f")
    host.end()

    assert before == pytest.approx(2000.0 / 100.0 * 10 * H)  # v = F t / m
    assert after - before == pytest.approx(-1000.0 / 100.0 * H)
    assert told == [-1000.0, -1000.0]
    assert np.array_equal(rows[:, 0], rows[:, 1])
    assert rows[:, 3] == pytest.approx(1e3 * rows[:, 2])


def test_an_input_without_a_value_begins_where_its_fmu_does(tmp_path):
    data = system(start=None)
    data["connectors"].pop("whole.passed")
    data["fmus"]["free"]["start"] = {"f": 250.0}
    data["connections"].pop()  # an output that shows the input would be 0 in a run, not 250
    experiment = prepared(tmp_path, data)
    fmu = exported(experiment, tmp_path)

    assert read_description(fmu).by_name["whole.force"].start_value == 0.25
    assert_same_bits(experiment, fmu)
