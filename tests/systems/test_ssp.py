"""The paper's system as an SSP archive: valid, read back to the same bits, loaded by another tool."""

import zipfile
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from lxml import etree

from master.api import prepare_to_run
from master.errors import ConfigError
from master.experiment.prepare import Request
from master.ssp.export import write_ssp
from master.stepping.simulate import simulate

CONFIG = Path(__file__).parents[2] / "configs" / "experiment.yaml"
SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"


@pytest.fixture(scope="module")
def experiment():
    return prepare_to_run(CONFIG, Request(variant="cfdc_fmdc", stop_time=0.5))


@pytest.fixture(scope="module")
def archive(experiment, tmp_path_factory):
    return write_ssp(experiment, tmp_path_factory.mktemp("ssp") / "system.ssp")


def values(experiment):
    return simulate(experiment.system, experiment.schedule, experiment.grid).result.values


@pytest.mark.parametrize(
    ("member", "schema"),
    [
        ("SystemStructure.ssd", "SystemStructureDescription.xsd"),
        ("resources/compensator.ssv", "SystemStructureParameterValues.xsd"),
    ],
)
def test_the_archive_keeps_the_schema_of_ssp_1(archive, member, schema):
    with zipfile.ZipFile(archive) as opened:
        document = etree.fromstring(opened.read(member))

    etree.XMLSchema(etree.parse(str(SCHEMAS / schema))).assertValid(document)


def test_a_system_read_back_gives_the_same_bits(archive, experiment):
    assert np.array_equal(values(prepare_to_run(archive)), values(experiment))


def test_order_delays_and_rates_come_back(experiment, tmp_path):
    system = experiment.system
    wires = tuple(replace(w, delay=2 * (w.target.name == "compensator.x")) for w in system.wires)
    connections = [
        c.model_copy(update={"delay": 2}) if c.target == "compensator.x" else c
        for c in experiment.config.connections
    ]
    config = experiment.config.model_copy(update={"connections": connections})
    changed = replace(experiment, config=config, system=replace(system, wires=wires))
    back = prepare_to_run(write_ssp(changed, tmp_path / "delayed.ssp"))

    assert back.schedule == experiment.schedule
    assert {w.target.name: w.delay for w in back.system.wires}["compensator.x"] == 2


def test_fmpy_loads_and_steps_it(archive):
    result = simulate_ssp(str(archive), stop_time=0.01, step_size=1e-3)

    assert "spacecraft.s_des" in result.dtype.names
    assert np.isfinite(result["spacecraft.s_des"]).all()


def test_a_file_that_is_no_archive_is_refused(tmp_path):
    path = tmp_path / "system.ssp"
    path.write_text("no zip", encoding="utf-8")

    with pytest.raises(ConfigError, match=r"not an SSP archive \(.*\), expected a zip file"):
        prepare_to_run(path)
