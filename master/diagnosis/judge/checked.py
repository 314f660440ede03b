"""A case checked without replaying anything: every fault at once, or what a diagnosis would work on."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from master import catalogue
from master.diagnosis.case.case import read_case
from master.diagnosis.data.measured_signals import opened
from master.diagnosis.data.split_rows import split_of
from master.diagnosis.replay.fitting_effects import candidates


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

    `notes` say by recording what was done to how many of its rows.
    """

    name: str
    rows: dict[str, int]
    period: float
    n_fit: int
    n_select: int
    parts: tuple[CheckedPart, ...]
    notes: dict[str, tuple[str, ...]]

    @property
    def rows_of_one_pass(self) -> int:
        """Rows that are stepped when each effect of each part is replayed once on what is fitted."""
        return sum((1 + part.n_effects) * self.n_fit for part in self.parts)


def check_case(path: Path, progress: catalogue.Progress = catalogue.silent) -> CheckedCase:
    """
    Check a case; the sealed rows stay sealed.

    Raises:
        ConfigError: With every fault of the case, its system and its recordings, or of its split.
    """
    loaded = read_case(path)
    system, recordings = opened(loaded, progress)
    split = split_of(loaded, recordings)
    parts = [
        CheckedPart(part.name, tuple(part.compared), len(candidates(system, part, loaded.case.slots)))
        for part in system.parts
    ]
    return CheckedCase(
        name=loaded.case.name,
        rows={name: len(recording) for name, recording in recordings.items()},
        period=next(iter(recordings.values())).period,
        n_fit=sum(map(len, split.fit)),
        n_select=sum(map(len, split.select)),
        parts=tuple(parts),
        notes={name: r.notes for name, r in recordings.items() if r.notes},
    )
