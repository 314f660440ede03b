"""How a run ended, and what it does besides stepping."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from master.errors import FmuError
from master.recording.recorder import Result, Sink
from master.stepping.pacing import Pacer
from master.system.scenario import Scenario

COMPLETED, DIVERGED, FAILED, INTERRUPTED, OVERRUN, TERMINATED = (
    "completed",
    "diverged",
    "failed",
    "interrupted",
    "overrun",
    "terminated",
)


@dataclass(frozen=True)
class RunOptions:
    """
    What a run does besides stepping.

    `limits`: largest magnitude by signal, beyond which the run has diverged. `compared`: signals that have to
    be finite even if nothing takes them. `scenario`: events. `pacer`: real time. `sink`: where all rows go;
    then every `keep_every`-th stays in memory.
    """

    limits: Mapping[str, float] = field(default_factory=dict)
    compared: Collection[str] = ()
    scenario: Scenario = field(default_factory=Scenario)
    pacer: Pacer | None = None
    sink: Sink | None = None
    keep_every: int = 1


@dataclass
class Outcome:
    """
    How a run ended and what it computed.

    `error` says why if it failed, `cause` why it ended early; `not_reached` are the conditions of a
    scenario that did not come true, `warnings` what did not end the run but should be known.
    """

    status: str
    result: Result
    seconds: float
    steps: int
    error: FmuError | None = None
    cause: str = ""
    real_time: dict[str, Any] | None = None
    not_reached: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
