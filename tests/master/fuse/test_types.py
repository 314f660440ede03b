"""Wires of integers and Booleans round, map and refuse in the fused FMU as they do in a run."""

from __future__ import annotations

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from fmu_sources.export.own_model import own_fmu
from master.stepping.outcome import FAILED
from master.stepping.simulate import simulate
from tests.master.fuse.fused_run import Host, assert_same_bits, expected_rows, exported, prepared
from tests.master.fuse.typed_model import Typed

pytestmark = pytest.mark.long


@pytest.fixture(scope="module", params=["2.0", "3.0"])
def source(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("typed") / "typed.fmu"
    path.write_bytes(own_fmu(Typed(), "native" if request.param == "2.0" else "fmi3"))
    return request.param, path


def system(source, factor: float) -> dict:
    return {
        "name": "typed values",
        "step_size": 0.01,
        "stop_time": 1.0,
        "fmus": {
            "mass": {"source": "spacecraft", "parameters": {"m_s": 0.7, "sample_time": 0.01}},
            "first": {"source": str(source)},
            "second": {"source": str(source)},
        },
        "coupling": {"order": ["first", "second", "mass"]},
        "connections": [
            {"from": "mass.s_des", "to": "first.level", "factor": factor, "offset": 2.0, "units": "ignored"},
            {"from": "first.count", "to": "second.level", "map": {4: 40, 6: -6}},
            {"from": "first.flag", "to": "second.gate", "delay": 2},
            {"from": "second.size", "to": "mass.f"},
        ],
    }


def test_integers_and_booleans_have_the_bits_of_run(source, tmp_path):
    version, path = source
    experiment = prepared(tmp_path, system(path, 3.0))
    names, values = expected_rows(experiment)

    assert_same_bits(experiment, exported(experiment, tmp_path, version))
    assert len(np.unique(values[:, names.index("first.count")])) > 3
    assert set(values[:, names.index("second.flag")]) == {0.0, 1.0}
    assert 41.0 in values[:, names.index("second.count")]


def test_a_value_that_an_integer_does_not_hold_ends_the_step_at_the_same_tick(source, tmp_path):
    version, path = source
    if version == "2.0":
        pytest.skip("the same code; FMPy prints the messages of FMI 2.0")
    experiment = prepared(tmp_path, system(path, 1e11))
    outcome = simulate(experiment.system, experiment.schedule, experiment.grid)
    host = Host(exported(experiment, tmp_path, version)).start()
    for k in range(outcome.steps):
        host.fmu.doStep(k * 0.01, 0.01)

    assert outcome.status == FAILED
    with pytest.raises(FMICallException):
        host.fmu.doStep(outcome.steps * 0.01, 0.01)
    assert "first.level: value does not fit Int32, got " in host.messages[-1]
    host.end()
