"""Run and analyse a configuration of the project under the same assumptions."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

from master.analysis.closed_loop.linearise import Linearisation
from master.analysis.summary import judge
from master.docking.conventions import CONVENTIONS
from master.evaluation.metrics import compute_metrics
from master.experiment.prepare import Request, prepare
from master.stepping.outcome import RunOptions
from master.stepping.simulate import simulate

CONFIGS = Path(__file__).parents[2] / "configs"


def prepared(name, variant=None, *assignments):
    return prepare(CONFIGS / f"{name}.yaml", Request(variant=variant, assignments=assignments))


def analysed(name, variant=None, *assignments):
    linearisation = Linearisation(prepared(name, variant, *assignments), CONVENTIONS, after_run=True)
    return judge(linearisation.coupled(), linearisation)


def simulated(name, variant=None, *assignments):
    """Metrics of a run, with its status and end."""
    experiment = prepared(name, variant, *assignments)
    outcome = simulate(
        experiment.system,
        experiment.schedule,
        experiment.grid,
        options=RunOptions(limits=experiment.limits),
    )
    metrics = compute_metrics(outcome.result, experiment.config.compare)
    return SimpleNamespace(
        **metrics, status=outcome.status, cause=outcome.cause, t_end=outcome.result.time[-1]
    )
