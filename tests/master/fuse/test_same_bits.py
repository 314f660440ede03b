"""A system as one FMU gives the bits of `dockloop run`, whatever its coupling."""

from __future__ import annotations

import pytest

from tests.master.fuse.fused_run import assert_same_bits, exported, prepared
from tests.master.fuse.systems import COUPLINGS, with_conversions


@pytest.mark.long
@pytest.mark.parametrize("coupling", COUPLINGS)
def test_every_way_of_coupling_has_the_bits_of_run(coupling, tmp_path):
    experiment = prepared(tmp_path, COUPLINGS[coupling])

    assert_same_bits(experiment, exported(experiment, tmp_path))


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_two_instances_of_one_fmu_open_inputs_and_converted_wires_have_the_bits_of_run(version, tmp_path):
    experiment = prepared(tmp_path, with_conversions())

    assert_same_bits(experiment, exported(experiment, tmp_path, version))
