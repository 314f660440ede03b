"""Write the reference experiments of all subsystems into `fmu_sources/<folder>/reference/`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from fmu_sources.composed import registry
from tests.oracles import (
    compensator_reference,
    guard_reference,
    hexapod_reference,
    linear_references,
    methods_reference,
    robust_reference,
)
from tests.oracles.reference_experiment import Experiment

MAKERS: dict[str, Callable[[], Experiment]] = {
    "compensator": compensator_reference.experiment,
    "spacecraft": linear_references.spacecraft,
    "motion_simulator_linear": linear_references.motion_simulator_linear,
    "motion_simulator": hexapod_reference.experiment,
    "docking_contact": linear_references.docking_contact,
    "real_docking": linear_references.real_docking,
    "force_sensor": linear_references.force_sensor,
    "guard": guard_reference.experiment,
    **methods_reference.experiments(),
    "robust": robust_reference.experiment,
}


def folder_of(model: str) -> Path:
    """Return the folder of a model's reference files."""
    return registry.model_files()[model].parent / "reference"


def main() -> None:
    """Write all files."""
    for model, maker in MAKERS.items():
        folder = folder_of(model)
        folder.mkdir(exist_ok=True)
        for name, content in maker().files().items():
            (folder / name).write_bytes(content)


if __name__ == "__main__":
    main()
