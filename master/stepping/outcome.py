"""How a run ended, and what it does besides stepping."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from master.errors import FmuError
from master.fmi.messages import MessageLog, Said
from master.recording.checkpoints import Durable
from master.recording.recorder import Result, Rows, Sink
from master.stepping.pacing import Pacer
from master.stepping.snapshot import Checkpoints, Snapshot
from master.system.inputs import MeasuredInputs
from master.system.scenario import Scenario

COMPLETED, DIVERGED, FAILED, INTERRUPTED, OVERRUN, STOPPED, TERMINATED = (
    "completed",
    "diverged",
    "failed",
    "interrupted",
    "overrun",
    "stopped",
    "terminated",
)


ProgressCallback = Callable[[int], None]


@dataclass(frozen=True)
class RunOptions:
    """
    What a run does besides stepping.

    `limits`: largest magnitude by signal, beyond which the run has diverged. `compared`: signals that have to
    be finite even if nothing takes them. `scenario`: events. `pacer`: real time. `sink`: where all rows go;
    then every `keep_every`-th stays in memory. `recorder`: where rows are collected instead of in memory of
    this process. `log`: takes the messages of FMUs. `inputs`: those under recordings. `checkpoints`: takes
    snapshots of the run; `begin_at`: the one that it goes on from. `durable`: where a run in a process of its
    own has its checkpoints saved; its rows go to a sink then.
    """

    limits: Mapping[str, float] = field(default_factory=dict)
    compared: Collection[str] = ()
    scenario: Scenario = field(default_factory=Scenario)
    pacer: Pacer | None = None
    sink: Sink | None = None
    keep_every: int = 1
    recorder: Rows | None = None
    log: MessageLog | None = None
    inputs: MeasuredInputs = field(default_factory=MeasuredInputs)
    checkpoints: Checkpoints | None = None
    begin_at: Snapshot | None = None
    durable: Durable | None = None

    def with_recorder(self, recorder: Rows) -> RunOptions:
        """Return the same with a place for the rows."""
        return replace(self, recorder=recorder)


@dataclass(frozen=True)
class Happened:
    """A condition of a scenario that came true, and the time of the row [s] that it was true in."""

    condition: str
    t: float


@dataclass
class Outcome:
    """
    How a run ended and what it computed.

    `error` says why if it failed, `cause` why it ended early; `not_reached` are the conditions of a
    scenario that did not come true, `happened` those that did, `warnings` what did not end the run but
    should be known, `messages` what FMUs said is wrong, `storage_fault` what went wrong with the files it
    wrote.
    """

    status: str
    result: Result
    seconds: float
    steps: int
    error: FmuError | None = None
    cause: str = ""
    real_time: dict[str, Any] | None = None
    not_reached: list[str] = field(default_factory=list)
    happened: list[Happened] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    storage_fault: str = ""
    messages: list[Said] = field(default_factory=list)
