"""The paper's loop as an SSP archive in Ecos: stepped side by side there and here, the same bits."""

from __future__ import annotations

import json
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from master.api import prepare_to_run
from master.coupling.schedule import Schedule
from master.experiment.prepare import Request
from master.ssp.export import write_ssp
from master.stepping.simulate import simulate

HERE = Path(__file__).parent
CONFIG = HERE.parents[1] / "configs" / "experiment.yaml"
SIGNALS = ("spacecraft.s_des", "motion_simulator.s_act", "compensator.f_des")

pytestmark = pytest.mark.slow


def test_ecos_steps_the_archive_to_the_bits_of_this_master(peer_python: Path, tmp_path: Path) -> None:
    experiment = prepare_to_run(CONFIG, Request(variant="cfdc_fmdc", stop_time=0.5))
    names = tuple(experiment.system.instances)
    side_by_side = Schedule((names,), dict.fromkeys(names, 1))
    ours = simulate(experiment.system, side_by_side, experiment.grid).result
    archive = write_ssp(replace(experiment, schedule=side_by_side), tmp_path / "system.ssp")

    command = [peer_python, HERE / "run_ssp_in_ecos.py", archive, str(experiment.grid.n_ticks), *SIGNALS]
    done = subprocess.run(command, capture_output=True, text=True, check=True)

    last_line = done.stdout.splitlines()[-1]
    assert json.loads(last_line) == {s: ours[s][-1] for s in SIGNALS}
