"""The paper's loop as an SSP archive in Ecos: stepped side by side there and here, the same bits."""

from __future__ import annotations

import json
import subprocess
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
from lxml import etree

from master.api import prepare_to_run
from master.coupling.methods.side_by_side import SideBySide
from master.coupling.schedule import Schedule
from master.experiment.prepare import Request
from master.fmi.description import Description
from master.ssp.export import write_ssp
from master.stepping.simulate import simulate
from master.system.graph import System

HERE = Path(__file__).parent
CONFIG = HERE.parents[1] / "configs" / "experiment.yaml"
SIGNALS = ("spacecraft.s_des", "motion_simulator.s_act", "compensator.f_des")

pytestmark = pytest.mark.slow


def test_ecos_steps_the_archive_to_the_bits_of_this_master(peer_python: Path, tmp_path: Path) -> None:
    experiment = prepare_to_run(CONFIG, Request(variant="cfdc_fmdc", stop_time=0.5))
    names = tuple(experiment.system.instances)
    side_by_side = Schedule.of([SideBySide(members=names)], dict.fromkeys(names, 1))
    ours = simulate(experiment.system, side_by_side, experiment.grid).result
    written = write_ssp(replace(experiment, schedule=side_by_side), tmp_path / "system.ssp")
    archive = without_enumerations(written, tmp_path / "for_ecos.ssp", experiment.system)

    command = [peer_python, HERE / "run_ssp_in_ecos.py", archive, str(experiment.grid.n_ticks), *SIGNALS]
    done = subprocess.run(command, capture_output=True, text=True, check=True)

    last_line = done.stdout.splitlines()[-1]
    assert json.loads(last_line) == {s: ours[s][-1] for s in SIGNALS}


def without_enumerations(written: Path, archive: Path, system: System) -> Path:
    """Leave out the values that Ecos cannot read, all of which the FMUs start with anyway."""
    with zipfile.ZipFile(written) as source, zipfile.ZipFile(archive, "w") as target:
        for name in source.namelist():
            content = source.read(name)
            if name.endswith(".ssv"):
                content = _without_enumerations(content, system.descriptions[Path(name).stem])
            target.writestr(name, content)
    return archive


def _without_enumerations(values: bytes, description: Description) -> bytes:
    root = etree.fromstring(values)
    for value in root.findall(".//{*}Enumeration"):
        parameter = value.getparent()
        variable = description.by_name[parameter.get("name")]
        assert str(variable.items[value.get("value")]) == variable.start
        parameter.getparent().remove(parameter)
    return etree.tostring(root)
