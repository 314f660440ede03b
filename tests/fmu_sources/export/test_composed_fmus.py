"""FMUs of models with effects refuse what the FMU of the base refuses, and have its terminals."""

from __future__ import annotations

import io
import zipfile

import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

from fmu_sources.composed.registry import load, modules
from fmu_sources.export.native_flavour import host_binaries, native_sources, pack_native
from fmu_sources.export.python_flavour import build_python

NAME = "motion_simulator__leg_force_1_coulomb"


def native(name, version="2.0"):
    pytest.importorskip("casadi")
    sources = native_sources(load(name), *modules(name))
    return pack_native(sources, host_binaries(sources) if version == "2.0" else {}, version)


def python(name):
    return build_python(load(name), *modules(name))


@pytest.mark.parametrize("build", [pytest.param(native, marks=pytest.mark.long), python])
def test_a_command_past_a_stop_is_refused_in_both_flavours(build, tmp_path):
    path = tmp_path / "simulator.fmu"
    path.write_bytes(build(NAME))
    description = read_model_description(str(path))
    slave = FMU2Slave(
        guid=description.guid,
        modelIdentifier=description.coSimulation.modelIdentifier,
        unzipDirectory=extract(str(path), str(tmp_path / "unpacked")),
        instanceName="simulator",
    )
    slave.instantiate(callbacks=None, loggingOn=True)
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    command = next(v.valueReference for v in description.modelVariables if v.name == "s_cmd")
    slave.setReal([command], [2.0])
    slave.exitInitializationMode()

    with pytest.raises(Exception, match="fmi2DoStep failed with status"):
        slave.doStep(0.0, 5e-3)
    slave.freeInstance()


def test_the_compensator_with_an_effect_has_the_plugs_of_the_compensator():
    name = "terminalsAndIcons/terminalsAndIcons.xml"
    plain, other = (
        zipfile.ZipFile(io.BytesIO(native(model, "3.0"))).read(name)
        for model in ("compensator", "compensator__command_extra_lag")
    )

    assert plain.count(b"<Terminal ") == 3
    assert other == plain
