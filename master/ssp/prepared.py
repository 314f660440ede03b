"""What an archive holds of a system that is ready to run."""

from __future__ import annotations

from typing import Protocol

from master.system.config import Config
from master.system.graph import System
from master.system.inputs import MeasuredInputs


class PreparedSystem(Protocol):
    """An `Experiment`, as far as an archive needs it: this package is below `master.experiment`."""

    @property
    def config(self) -> Config: ...

    @property
    def variant(self) -> str | None: ...

    @property
    def system(self) -> System: ...

    @property
    def inputs(self) -> MeasuredInputs: ...
