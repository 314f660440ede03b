"""A case from its file to all files of the answer."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from fmu_sources.export import build

from ..experiment import prepare
from .case import load_case
from .corrected import correct
from .page import page
from .panels import panels
from .pipeline import diagnose
from .sealed import sealed
from .study import Progress
from .verdict import as_dict


def answer(path: Path, folder: Path, progress: Progress) -> dict[str, Any]:
    """
    Diagnose a case and write report, panels, corrected FMUs and system into a folder.

    Raises:
        ConfigError: If the case or what it names is wrong.
    """
    diagnosis = diagnose(load_case(path), progress)
    try:
        progress("models with effects are written")
        corrected = correct(diagnosis, folder)
        prepare(corrected.system)
        progress("sealed rows are read, once")
        found = sealed(diagnosis, corrected.native)
        progress("report is drawn")
        drawn = panels(diagnosis, found, folder / "panels")
        files = [*corrected.files, *drawn, folder / "report.html", folder / "report.json"]
        report = as_dict(diagnosis, found, [f.relative_to(folder).as_posix() for f in files])
    finally:
        diagnosis.close()
    build.write(folder / "report.json", (json.dumps(report, indent=2, allow_nan=False) + "\n").encode())
    build.write(folder / "report.html", page(report, drawn).encode())
    return report
