"""A system as one FMU gives the bits of `dockloop run`, whatever its coupling."""

from __future__ import annotations

import pytest

from master.installation import configuration
from tests.master.fuse.fused_run import assert_same_bits, exported, prepared
from tests.master.fuse.systems import COUPLINGS


@pytest.mark.long
@pytest.mark.parametrize("coupling", COUPLINGS)
def test_every_way_of_coupling_has_the_bits_of_run(coupling, tmp_path):
    experiment = prepared(tmp_path, COUPLINGS[coupling])

    assert_same_bits(experiment, exported(experiment, tmp_path))


def test_two_instances_of_one_fmu_open_inputs_and_converted_wires_have_the_bits_of_run(converted):
    assert_same_bits(converted.experiment, converted.fmu)


@pytest.mark.long
def test_the_docking_loop_with_its_compensator_has_the_bits_of_run(tmp_path):
    experiment = prepared(tmp_path, configuration("experiment"), stop_time=1.0)

    assert_same_bits(experiment, exported(experiment, tmp_path))
