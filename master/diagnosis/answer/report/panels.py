"""Panels of a diagnosis: charts for the page, each a PNG file too, and the text below them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.text import Text

from master.diagnosis.answer.before_after import SealedPart
from master.diagnosis.answer.port_names import chart_with_port_names
from master.diagnosis.judge.diagnose import Diagnosis
from master.diagnosis.judge.part_result import PartResult
from master.pages.chart import Chart

from .charts import residual_charts, sealed_charts
from .compared import compared
from .drawing import save
from .law_in_slot import law_in_slot
from .learned_law import law
from .named_law import law_charts, law_figure, law_text
from .residual import residual, where
from .rivals import rivals

SEALED = (
    "Measured and simulated on the sealed rows, which nothing was fitted to or selected by, and the "
    "residual, measured less simulated. Several recordings follow each other in time."
)
RESIDUAL = "Residual on the rows that are open, over time and as a spectrum."
WHERE = (
    "What the residual correlates with (prewhitened; coloured bars are significant at 1 % over all signals "
    "and lags), and its map over the state: what is missing, and where."
)
RIVALS = (
    "Gain of each effect on held-out blocks, ln of the ratio of residual powers before and after, with two "
    "standard errors; the winner of each round is coloured."
)


@dataclass(frozen=True)
class Panel:
    """
    A picture: the part it shows, its file, the text below it, and charts in its place on the page.

    That of a named law, `law` as `fmu.slot: effect`, is shown with the law; it has no file where it cannot be
    drawn, and the text says why.
    """

    part: str
    file: Path | None
    text: str
    charts: Sequence[Chart] = ()
    law: str = ""


def panels(diagnosis: Diagnosis, sealed: Mapping[str, SealedPart], folder: Path) -> list[Panel]:
    """Draw all panels into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    return [p for part in diagnosis.parts for p in _panels(diagnosis, part, sealed, folder)]


def _panels(
    diagnosis: Diagnosis, part: PartResult, sealed: Mapping[str, SealedPart], folder: Path
) -> list[Panel]:
    system = diagnosis.system
    own = sealed[part.name]
    name = part.name
    stem = name.replace(" and ", "_")

    def panel(kind: str, figure: Figure, text: str, charts: Sequence[Chart] = ()) -> Panel:
        for label in figure.findobj(Text):
            assert isinstance(label, Text)
            label.set_text(system.spoken(label.get_text()))
        shown = [chart_with_port_names(chart, system) for chart in charts]
        return Panel(name, save(figure, folder / f"{stem}_{kind}.png"), system.spoken(text), shown)

    found = [panel("sealed", compared(system, own), SEALED, sealed_charts(system, own))]
    if not part.is_exact:
        found.append(panel("residual", residual(part), RESIDUAL, residual_charts(part)))
        found.append(panel("where", where(part), WHERE))
    if part.search is not None and any(step.ranked for step in part.search.rounds):
        found.append(panel("rivals", rivals(part.search), RIVALS))
    is_learned = part.learned is not None and part.learned.model.effects == part.chosen.effects
    if part.learned is not None and is_learned:
        found.append(panel("learned", law(part), f"The law that was learned: {part.learned.shape}."))
    for placed in part.chosen.effects[: -1 if is_learned else None]:
        named = law_in_slot(part, placed)
        text = law_text(named)
        if named.why_not:
            found.append(Panel(name, None, system.spoken(text), law=system.spoken(str(placed))))
            continue
        drawn = panel(f"law_{placed.prefix}", law_figure(part, named), text, law_charts(part, named))
        found.append(replace(drawn, law=system.spoken(str(placed))))
    return found
