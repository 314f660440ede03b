"""A figure of the paper or one of ours: what it shows, the runs it needs, and how it is drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from master.pages.chart import Chart
from master.reproduce.measures.runs import Recording, Run, Wanted


@dataclass(frozen=True)
class Figure:
    """What the paper's figure shows, what ours shows, the signals of the runs it needs, and its charts."""

    id: str
    title: str
    paper: str
    ours: str
    runs: Mapping[Run, Sequence[str]]
    draw: Callable[[Mapping[Run, Recording]], Sequence[Chart]]

    @property
    def wishes(self) -> dict[Run, Wanted]:
        """Signals that are drawn."""
        return {run: Wanted(signals=frozenset(signals)) for run, signals in self.runs.items()}
