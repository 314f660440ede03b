"""What commands do with a system before they step it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from master import catalogue
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request, prepare
from master.fmi.description import Description
from master.process.child import done_apart
from master.system.config import LoadedConfig


def prepare_to_run(
    source: Path | LoadedConfig,
    request: Request | None = None,
    progress: catalogue.Progress = catalogue.silent,
    given: Mapping[str, Description] | None = None,
) -> Experiment:
    """
    Prepare a system and design its phase lead where the file asks for it, which steps FMUs.

    Raises:
        ConfigError: With every fault, or if no lead can be designed.
        FmuError: If an FMU fails during the design.
    """
    experiment = prepare(source, request, progress, given)
    if experiment.phase_lead is None or experiment.is_designed:
        return experiment
    from master.docking.phase_lead import designed

    return done_apart(lambda: designed(experiment))
