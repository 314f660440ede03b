"""A case from its file to all files of the answer."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from fmu_sources.effects.framework.placed import Placed
from master import catalogue
from master.diagnosis.answer.report.page import page
from master.diagnosis.answer.report.panels import panels
from master.diagnosis.case.case import read_case
from master.diagnosis.judge.diagnose import Diagnosis, diagnose
from master.diagnosis.search.deadline import Deadline
from master.diagnosis.search.study import Progress
from master.fmi.description_reader import read_description
from master.recording.whole_file import write_whole

from .before_after import sealed
from .corrected_fmus import Corrected, confirmed, correct
from .port_names import with_port_names
from .verdict import as_dict


def answer(
    path: Path,
    folder: Path,
    progress: Progress,
    deadline: Deadline | None = None,
    announce: Progress = catalogue.silent,
) -> dict[str, Any]:
    """
    Diagnose a case and write report, panels, corrected FMUs and system into a folder.

    No FMU stays loaded, however it ends. Once the deadline is over, the best so far is reported. `announce`
    is told once, at the start, what it will cost.

    Raises:
        ConfigError: If the case or what it names is wrong.
        FmuError: If an FMU cannot be replayed on what was measured.
    """
    with diagnose(read_case(path), progress, deadline, announce) as diagnosis:
        progress("models with effects are written")
        corrected = correct(diagnosis, folder)
        progress("sealed rows are read, once")
        parts = sealed(diagnosis, corrected.native)
        corrected = confirmed(diagnosis, corrected, parts, folder)
        progress("report is drawn")
        drawn = panels(diagnosis, parts, folder / "panels")
        pictures = (panel.file for panel in drawn if panel.file)
        files = [*corrected.files, *pictures, folder / "report.html", folder / "report.json"]
        names = [f.relative_to(folder).as_posix() for f in files]
        report = with_port_names(as_dict(diagnosis, parts, names), diagnosis.system)
        units = _units(diagnosis, corrected)
    write_whole(folder / "report.json", json.dumps(report, indent=2, allow_nan=False) + "\n")
    write_whole(folder / "report.html", page(report, drawn, units))
    return report


def _units(diagnosis: Diagnosis, corrected: Corrected) -> dict[str, str]:
    """Units of all variables `fmu.name`, of models with effects too."""
    system = diagnosis.system
    descriptions = dict(system.descriptions)
    descriptions |= {fmu: read_description(file) for fmu, file in corrected.native.items()}
    units = {f"{fmu}.{name}": v.unit_name for fmu, d in descriptions.items() for name, v in d.by_name.items()}
    for carrier in system.carriers.values():  # its own file knows nothing of the units of the port
        units |= dict.fromkeys((f"{carrier.name}.u", f"{carrier.name}.y"), carrier.unit)
    for placed in (e for part in diagnosis.parts for e in part.chosen.effects if e.fmu in system.carriers):
        own = Placed(system.slots(placed.fmu)[placed.slot], placed.law, placed.prefix, "outputs")
        units |= {f"{placed.fmu}.{v.name}": v.unit for v in own.declarations({})}
    return {system.spoken(name): unit for name, unit in units.items()}
