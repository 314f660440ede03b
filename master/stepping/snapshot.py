"""
All of a run at one tick, in bytes from which another process goes on with the same bits.

It holds the states of the FMUs, serialised by themselves, and the memory of the master: the table of values,
older values of delays and extrapolation, connections under events with their random numbers, what has been
played of the scenario, the messages so far. What follows from the configuration (the program, the measured
inputs) is made again from that.
"""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from master.errors import ConfigError, DataError, Problem
from master.stepping.machine.interpreter import LimitMonitor
from master.stepping.machine.program import RESTORE, SAVE, Program
from master.system.graph import System

_ARRAYS = ("values", "rings", "channels", "triggers", "first_beyond")
_FMU = "fmu."
_REST = "rest"


@dataclass(frozen=True)
class Snapshot:
    """
    All of a run after `tick` ticks.

    `fmus` are serialised states by instance, `arrays` the changing ones of the program and of its limit
    monitor, `player` and `messages` the states of scenario player and message log, `seconds` the time spent
    in the stepping loop [s], `layout` a digest of the program.
    """

    tick: int
    seconds: float
    layout: str
    fmus: Mapping[str, bytes]
    arrays: Mapping[str, NDArray[Any]]
    player: Mapping[str, Any]
    messages: Mapping[str, Any]

    def to_bytes(self) -> bytes:
        """Return it as an NPZ archive without pickled objects."""
        rest = {
            "tick": self.tick,
            "seconds": self.seconds,
            "layout": self.layout,
            "fmus": list(self.fmus),
            "player": self.player,
            "messages": self.messages,
        }
        arrays: dict[str, NDArray[Any]] = dict(self.arrays)
        for i, data in enumerate(self.fmus.values()):
            arrays[f"{_FMU}{i}"] = np.frombuffer(data, np.uint8)
        arrays[_REST] = np.frombuffer(json.dumps(rest).encode(), np.uint8)
        written = io.BytesIO()
        np.savez(written, allow_pickle=False, **arrays)
        return written.getvalue()

    @classmethod
    def from_bytes(cls, data: bytes) -> Snapshot:
        """
        Read what `to_bytes` returned.

        Raises:
            ValueError: If it is something else, or damaged.
        """
        try:
            with np.load(io.BytesIO(data), allow_pickle=False) as archive:
                rest = json.loads(archive[_REST].tobytes())
                fmus = {name: archive[f"{_FMU}{i}"].tobytes() for i, name in enumerate(rest.pop("fmus"))}
                return cls(fmus=fmus, arrays={name: archive[name] for name in _ARRAYS}, **rest)
        except (KeyError, TypeError, OSError, EOFError, zipfile.BadZipFile) as error:
            raise ValueError(f"not a snapshot of a run: {error}") from None


class Checkpoints(Protocol):
    """Takes snapshots of a run that goes on."""

    def is_due(self) -> bool:
        """Whether a snapshot is wanted now."""
        ...

    def put(self, snapshot: Snapshot) -> None:
        """Take one."""
        ...


def require_serialisable(system: System, where: str) -> None:
    """
    Refuse FMUs whose state cannot leave their process.

    Raises:
        ConfigError: With each of them by its name; `where` is the option that needs it.
    """
    flag = {2: "canSerializeFMUstate", 3: "canSerializeFMUState"}
    problems = [
        Problem(
            "cannot write its state to a file",
            where=f"{where}: {name}",
            got=f"no {flag[i.description.version]} in {i.description.path.name}",
            expected="FMUs that can, or a run without checkpoints",
        )
        for name, i in system.instances.items()
        if not (i.description.can_get_and_set_state and i.description.can_serialise_state)
    ]
    if problems:
        raise ConfigError(problems)


def layout_of(program: Program, monitor: LimitMonitor) -> str:
    """Digest of what a program is made of, without the addresses of this process."""
    memory = program.memory
    operations = memory.operations.copy()
    has_address = np.isin(operations[:, 0], (SAVE, RESTORE))
    operations[has_address, 3] = 0
    whole = hashlib.sha256(json.dumps([program.place, program.slaves]).encode())
    parts: Iterable[NDArray[Any]] = (
        *(operations, memory.copies, memory.conversions, memory.maps, memory.feeds, memory.loops[:, :4]),
        *(memory.residuals, memory.tolerances, monitor.record, monitor.limits, monitor.used),
        monitor.thresholds,
    )
    for part in parts:
        whole.update(str(part.shape).encode())
        whole.update(np.ascontiguousarray(part).tobytes())
    return whole.hexdigest()


def arrays_of(program: Program, monitor: LimitMonitor) -> dict[str, NDArray[Any]]:
    """Copy the arrays that change while a run steps."""
    memory = program.memory
    found = {
        "values": memory.values,
        "rings": memory.rings,
        "channels": memory.channels,
        "triggers": monitor.triggers,
        "first_beyond": monitor.first_beyond,
    }
    return {name: array.copy() for name, array in found.items()}


def restore_arrays(snapshot: Snapshot, program: Program, monitor: LimitMonitor) -> None:
    """
    Put the arrays back.

    Raises:
        DataError: If the program is not that of the snapshot.
    """
    if snapshot.layout != layout_of(program, monitor):
        expected = "the system and the version of dockloop that it was made with"
        raise DataError(f"checkpoint: does not belong to this system, expected {expected}")
    memory = program.memory
    for name, array in (
        ("values", memory.values),
        ("rings", memory.rings),
        ("channels", memory.channels),
        ("triggers", monitor.triggers),
        ("first_beyond", monitor.first_beyond),
    ):
        array[...] = snapshot.arrays[name]
