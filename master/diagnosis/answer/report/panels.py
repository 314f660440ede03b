"""Panels of a diagnosis as PNG, each with the text that stands below it on the page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from master.diagnosis.answer.before_after import SealedPart
from master.diagnosis.judge.diagnose import Diagnosis
from master.diagnosis.judge.part_result import PartResult

from .compared import compared
from .drawing import save
from .learned_law import law
from .residual import residual
from .rivals import rivals

SEALED = (
    "Measured and simulated on the sealed rows, which nothing was fitted to or selected by: all of them on "
    "the left, the stretch where the model was worst on the right; below each the residual, measured less "
    "simulated. Several recordings follow each other in time."
)
RESIDUAL = (
    "Residual on the rows that are open: over time, its spectrum, what it correlates with (prewhitened; "
    "coloured bars are significant at 1 % over all signals and lags), and its map over the state: what is "
    "missing, and where."
)
RIVALS = (
    "Gain of each effect on held-out blocks, ln of the ratio of residual powers before and after, with two "
    "standard errors; the winner of each round is coloured."
)


@dataclass(frozen=True)
class Panel:
    """A picture: the part it shows, its file, and the text below it."""

    part: str
    file: Path
    text: str


def panels(diagnosis: Diagnosis, sealed: Mapping[str, SealedPart], folder: Path) -> list[Panel]:
    """Draw all panels into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    return [p for part in diagnosis.parts for p in _panels(diagnosis, part, sealed, folder)]


def _panels(
    diagnosis: Diagnosis, part: PartResult, sealed: Mapping[str, SealedPart], folder: Path
) -> list[Panel]:
    name = part.name
    figures = [("sealed", compared(diagnosis.system, sealed[name]), SEALED)]
    if not part.is_exact:
        figures.append(("residual", residual(part), RESIDUAL))
    if part.search is not None and any(step.ranked for step in part.search.rounds):
        figures.append(("rivals", rivals(part.search), RIVALS))
    if part.learned is not None and part.learned.model.effects == part.chosen.effects:
        figures.append(("learned", law(part), f"The law that was learned: {part.learned.shape}."))
    stem = name.replace(" and ", "_")
    return [Panel(name, save(f, folder / f"{stem}_{kind}.png"), text) for kind, f, text in figures]
