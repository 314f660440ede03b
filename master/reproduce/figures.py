"""All figures, in the paper's order, and then ours."""

from __future__ import annotations

from . import figures_analysis, figures_experiment, figures_simulation, figures_varying
from .plot import Figure

PAPER: tuple[Figure, ...] = (
    *figures_simulation.FIGURES,
    *figures_varying.FIGURES,
    *figures_analysis.FIGURES,
    *figures_experiment.FIGURES,
)
FIGURES: tuple[Figure, ...] = (*PAPER, *figures_analysis.EXTRA)
