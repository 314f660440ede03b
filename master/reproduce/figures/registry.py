"""All figures, in the paper's order, and then ours."""

from __future__ import annotations

from . import analysis, experiment, simulation, varying
from .figure import Figure

PAPER: tuple[Figure, ...] = (
    *simulation.FIGURES,
    *varying.FIGURES,
    *analysis.FIGURES,
    *experiment.FIGURES,
)
FIGURES: tuple[Figure, ...] = (*PAPER, *analysis.EXTRA)
