"""Write the reference experiments of all subsystems into `fmu_sources/<room>/reference/`."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import compensator_reference
import hexapod_reference
import linear_references
from reference_experiment import Experiment

ROOMS = Path(__file__).parents[2] / "fmu_sources"

MAKERS: dict[str, tuple[str, Callable[[], Experiment]]] = {
    "compensator": ("compensator", compensator_reference.experiment),
    "spacecraft": ("spacecraft", linear_references.spacecraft),
    "motion_simulator_linear": ("motion_simulator", linear_references.motion_simulator_linear),
    "motion_simulator": ("motion_simulator", hexapod_reference.experiment),
    "docking_contact": ("docking_contact", linear_references.docking_contact),
    "real_docking": ("real_docking", linear_references.real_docking),
    "force_sensor": ("force_sensor", linear_references.force_sensor),
}


def folder_of(model: str) -> Path:
    """Where the files of a model stand."""
    return ROOMS / MAKERS[model][0] / "reference"


def main() -> None:
    """Write all files."""
    for model, (_, maker) in MAKERS.items():
        folder = folder_of(model)
        folder.mkdir(exist_ok=True)
        for name, content in maker().files().items():
            (folder / name).write_bytes(content)


if __name__ == "__main__":
    main()
