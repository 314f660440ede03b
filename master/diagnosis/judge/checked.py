"""A case checked without replaying anything: every fault at once, or what a diagnosis would work on."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from master import catalogue
from master.diagnosis.case.case import read_case
from master.diagnosis.data.measured_signals import opened
from master.diagnosis.data.split_rows import split_of

from .cost import Cost, cost_of


@dataclass(frozen=True)
class CheckedPart:
    """FMUs that are replayed together, the signals that they are compared with, and effects to consider."""

    name: str
    compared: tuple[str, ...]
    n_effects: int


@dataclass(frozen=True)
class CheckedCase:
    """
    What a case holds: rows of each recording, their period [s], rows to fit and select by, parts.

    `notes` say by recording what was done to how many of its rows, `cost` what a diagnosis would cost.
    """

    name: str
    rows: dict[str, int]
    period: float
    n_fit: int
    n_select: int
    parts: tuple[CheckedPart, ...]
    notes: dict[str, tuple[str, ...]]
    cost: Cost


def check_case(path: Path, progress: catalogue.Progress = catalogue.silent) -> CheckedCase:
    """
    Check a case; the sealed rows stay sealed.

    Raises:
        ConfigError: With every fault of the case, its system and its recordings, or of its split.
    """
    loaded = read_case(path)
    system, recordings = opened(loaded, progress)
    loaded = system.loaded
    split = split_of(loaded, recordings)
    cost = cost_of(loaded, system, recordings, split)
    parts = [
        CheckedPart(part.name, tuple(part.compared), own.effects)
        for part, own in zip(system.parts, cost.parts, strict=True)
    ]
    return CheckedCase(
        name=loaded.case.name,
        rows={name: len(recording) for name, recording in recordings.items()},
        period=next(iter(recordings.values())).period,
        n_fit=sum(map(len, split.fit)),
        n_select=sum(map(len, split.select)),
        parts=tuple(parts),
        notes={name: r.notes for name, r in recordings.items() if r.notes},
        cost=cost,
    )
