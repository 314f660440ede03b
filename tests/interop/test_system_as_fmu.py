"""
A system as one FMU gives in other tools, bit for bit, what `dockloop run` computes.

Compiled from the sources of its FMUs, with events, and with FMUs of another tool carried along.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from fmpy import extract

from tests.interop.experiment_in_fmu import Vectors, in_fmpy
from tests.interop.other_tools import require, unpack_library
from tests.interop.test_importers import folder_for, in_host, in_peer
from tests.master.fuse.fused_run import bare, expected_rows, exported, prepared
from tests.master.fuse.systems import EVENTS, with_conversions

pytestmark = [pytest.mark.slow, pytest.mark.long]

STEP = 1e-3
OUTPUTS = ["spacecraft.s_des", "other.v_des", "free.s_des", "force_sensor.f_mea", "contact.f_act"]


def system(kind: str, folder: Path) -> dict:
    data = with_conversions() | {"stop_time": 0.25}
    if kind == "events":
        data["events"] = [event for events in EVENTS.values() for event in events]
    elif kind == "foreign":
        for name in ("contact", "force_sensor", "free"):
            data["fmus"][name]["source"] = str(bare(folder, data["fmus"][name]["source"]))
    return data


@pytest.fixture(
    scope="module",
    params=[(k, v) for k in ("native", "events", "foreign") for v in ("2.0", "3.0")],
    ids=" ".join,
)
def fused(request, tmp_path_factory) -> Vectors:
    kind, version = request.param
    folder = tmp_path_factory.mktemp("fused")
    experiment = prepared(folder, system(kind, folder))
    names, values = expected_rows(experiment)
    time = STEP * np.arange(len(values))
    inputs = np.array([(t, 2.0) for t in time], dtype=[("time", float), ("free.f", float)])
    chosen = [values[:, names.index(name)] for name in OUTPUTS]
    outputs = np.rec.fromarrays([time, *chosen], names=["time", *OUTPUTS])
    return Vectors(exported(experiment, folder, version), {"spacecraft.m_s": 820.0}, inputs, outputs, STEP)


def assert_same(given: Vectors, got: np.ndarray, first: int = 0) -> None:
    expected = np.column_stack([given.outputs[name] for name in OUTPUTS])

    assert np.array_equal(got, expected[first:])


def test_fmpy(fused):
    assert_same(fused, in_fmpy(fused, fused.fmu, fused.parameters))


def test_a_plain_c_host(fused, host, tmp_path):
    require(shutil.which("cc"), "apt-get install gcc libc6-dev")
    library = unpack_library(fused.fmu, folder_for(fused, "linux64", "x86_64-linux"), tmp_path)
    program: Path = host(["cc", "-Wall", "-Wextra", "-Werror"], "host")
    unpacked = Path(extract(str(fused.fmu), tmp_path / "unpacked")) / "resources"
    resources = folder_for(fused, unpacked.as_uri(), f"{unpacked}/")

    assert_same(fused, in_host([str(program)], library, fused, tmp_path, resources))


def test_ecospy(fused, peer_python, tmp_path):
    imported = subprocess.run([peer_python, "-c", "import ecospy"], capture_output=True, check=False)
    require(imported.returncode == 0, "apt-get install libtbb12")

    assert_same(fused, in_peer(peer_python, "run_in_ecos.py", fused, tmp_path))


def test_libcosimpy(fused, peer_python, tmp_path):
    if folder_for(fused, "2.0", "3.0") == "3.0":
        pytest.skip("libcosim reads FMI 2.0")

    assert_same(fused, in_peer(peer_python, "run_in_cosim.py", fused, tmp_path), first=1)
