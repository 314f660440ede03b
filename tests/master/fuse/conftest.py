from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest

from master.experiment.experiment import Experiment
from tests.master.fuse.fused_run import exported, prepared
from tests.master.fuse.systems import with_conversions


class Exported(NamedTuple):
    """A system and the FMU that was made of it."""

    experiment: Experiment
    fmu: Path


@pytest.fixture(scope="session", params=["2.0", "3.0"])
def converted(request, tmp_path_factory) -> Exported:
    """Two instances of one FMU, open inputs and converted wires, as an FMU of either version."""
    folder = tmp_path_factory.mktemp("fused")
    experiment = prepared(folder, with_conversions())
    return Exported(experiment, exported(experiment, folder, request.param))
