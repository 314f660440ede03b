"""The page of a run: plots, metrics, the system with the age of every wire, parameters, manifest."""

from __future__ import annotations

import json
from pathlib import Path

from master.evaluation.metrics import UNITS, compute_metrics
from master.evaluation.run_charts import RunCharts, run_charts
from master.experiment.experiment import Experiment
from master.pages.render import number, render
from master.recording.folder import PAGE
from master.recording.whole_file import write_whole
from master.stepping.outcome import Outcome
from master.system.config import Event

from .diagram import age, diagram_uri
from .manifest import Manifest


def write_page(experiment: Experiment, outcome: Outcome, manifest: Manifest, folder: Path) -> Path:
    """
    Write the page of a run into its folder.

    Raises:
        OSError: If it cannot be written.
    """
    path = folder / PAGE
    has_rows = len(outcome.result.time) > 0
    drawn = run_charts(experiment, outcome) if has_rows else RunCharts([])
    compare = experiment.compare
    metrics = {} if compare is None or not has_rows else compute_metrics(outcome.result, compare)
    text = render(
        "master.runs",
        "run.html.j2",
        heading=experiment.title,
        said=str(outcome.error or outcome.cause or ""),
        outcome=outcome,
        t_end=experiment.grid.time(outcome.steps),
        charts={"run": drawn.charts},
        remark=drawn.remark,
        metrics=[[name, number(value, 6), UNITS.get(name, "1")] for name, value in metrics.items()],
        diagram=diagram_uri(experiment),
        wires=[[e.source, e.target, age(e)] for e in experiment.ledger.entries],
        parameters=_parameters(experiment),
        events=[_event(e) for e in experiment.config.events],
        stop_when=experiment.config.stop_when,
        happened=outcome.happened,
        limits=[[name, f"{limit:g}", outcome.result.unit(name)] for name, limit in experiment.limits.items()],
        manifest=_manifest_rows(manifest),
    )
    write_whole(path, text)
    return path


def _event(event: Event) -> str:
    return json.dumps(event.model_dump(mode="json", exclude_defaults=True, by_alias=True))


def _parameters(experiment: Experiment) -> list[list[str]]:
    """Value of every parameter; those that are not the FMU's own are marked."""
    rows = []
    for name, instance in experiment.system.instances.items():
        for variable in instance.description.variables:
            if variable.causality not in ("parameter", "structuralParameter"):
                continue
            value = instance.value_of(variable.name)
            origin = "the FMU" if variable.name not in instance.start else "the file"
            if f"{name}.{variable.name}" in experiment.overridden:
                origin = "variant or --set"
            shown = f"{value:.9g}" if isinstance(value, float) else str("-" if value is None else value)
            rows.append([f"{name}.{variable.name}", shown, variable.unit_name, origin])
    return rows


def _manifest_rows(manifest: Manifest) -> list[list[str]]:
    rows = [
        ["command", " ".join(manifest.command)],
        ["configuration", f"{manifest.configuration.path}, sha256 {manifest.configuration.sha256}"],
        *([f"dockloop {key}", str(value)] for key, value in manifest.dockloop.items()),
        *([f"FMU of {name}", f"{fmu.source}, sha256 {fmu.sha256}"] for name, fmu in manifest.fmus.items()),
        *([f"recording {name}", f"sha256 {file.sha256}"] for name, file in manifest.inputs.items()),
        *([f"seed {name}", str(seed)] for name, seed in manifest.seeds.items()),
        *([key, str(value)] for key, value in manifest.machine.items()),
        ["started", manifest.started],
        ["duration [s]", f"{manifest.duration:.3f}"],
    ]
    return [list(map(str, row)) for row in rows]
