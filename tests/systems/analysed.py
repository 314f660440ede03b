"""Run and analyse a configuration of the project under the same assumptions."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

from master.analysis.summary import analyse
from master.api import prepare_to_run
from master.evaluation.metrics import compute_metrics
from master.experiment.prepare import Request
from master.stepping.outcome import RunOptions
from master.stepping.simulate import simulate

CONFIGS = Path(__file__).parents[2] / "configs"


def prepared(name, variant=None, *assignments):
    return prepare_to_run(CONFIGS / f"{name}.yaml", Request(variant=variant, assignments=assignments))


def analysed(name, variant=None, *assignments):
    return analyse(prepared(name, variant, *assignments))


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
