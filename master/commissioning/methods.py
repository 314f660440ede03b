"""A configuration as it is, or with a method of the suite in the place of its compensator."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from master.api import prepare_to_run
from master.catalogue import Progress
from master.comparison.cells import Cell
from master.comparison.methods import chosen
from master.comparison.systems import Base, system
from master.errors import ConfigError, Problem
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request
from master.system.config import Config, LoadedConfig
from master.text.validation import validated
from master.text.yaml_lines import Document

AS_CONFIGURED = "as configured"


class PreparedMethod(NamedTuple):
    """A method by its name, and the system with it."""

    method: str
    experiment: Experiment


def prepared_methods(
    config: Path, request: Request, methods: str | None, progress: Progress
) -> Iterator[PreparedMethod]:
    """
    Prepare a system for each method that is asked for; without any, as it is configured.

    Raises:
        ConfigError: If the configuration or a name is wrong, or a variant is asked for with methods.
    """
    if methods is None:
        yield PreparedMethod(AS_CONFIGURED, prepare_to_run(config, request, progress))
        return
    wanted = chosen(methods)
    if request.variant is not None:
        what = "is of the compensator that --methods replaces"
        raise ConfigError(
            [Problem(what, where="--variant", got=repr(request.variant), expected="one of them")]
        )
    base = Base(config)
    for method in wanted:
        document = Document(config, system(base, Cell(), method, 1))
        loaded = LoadedConfig(validated(Config, document, "system"), document)
        yield PreparedMethod(method.name, prepare_to_run(loaded, request, progress))
