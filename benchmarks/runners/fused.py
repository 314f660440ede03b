"""The system as one FMU (`dockloop export-fmu`), stepped by a C program that makes its FMI calls alone."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import bare_fmi

from master.api import prepare_to_run
from master.fmi.description_reader import read_description
from master.fuse.export import write_fmu


def main(spec_path: str, n_steps: str) -> None:
    """Export a system, step it and answer; the FMU is made once for all repetitions."""
    path = Path(spec_path)
    given = json.loads(path.read_text(encoding="utf-8"))
    fmu = path.parent / "fused.fmu"
    config = path.with_name("system.yaml")
    if not fmu.is_file() or fmu.stat().st_mtime < config.stat().st_mtime:
        write_fmu(prepare_to_run(config), fmu)
    about = read_description(fmu)
    spec = {
        "step_size": given["step_size"],
        "order": [["fused"]],
        "connections": [],
        "fmus": {
            "fused": {
                "path": str(fmu),
                "start": {},
                "references": {v.name: v.reference for v in about.variables},
                "kinds": {v.name: v.kind.value for v in about.variables},
                "outputs": [f"{n}.{v}" for n, one in given["fmus"].items() for v in one["outputs"]],
                "identifier": about.model_identifier,
                "token": about.token,
            }
        },
    }
    bare_fmi.run(spec, n_steps, path.parent / "fused")


if __name__ == "__main__":
    main(*sys.argv[1:])
