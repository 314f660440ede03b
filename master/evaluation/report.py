"""What a run leaves behind: files in a folder, and a summary for people and for programs."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from master.experiment.experiment import Experiment
from master.recording.files import ResultFiles, write_result
from master.stepping.outcome import Outcome

from .metrics import Metrics, compute_metrics
from .plots import plot_run


@dataclass(frozen=True)
class Report:
    """Summary of a run; the fields are the keys of `--json`."""

    name: str
    variant: str | None
    status: str
    t_end: float
    steps: int
    us_per_step: float | None
    realtime_factor: float | None
    files: dict[str, str]
    metrics: Metrics
    message: str = ""
    real_time: dict[str, Any] | None = None
    not_reached: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def as_dict(self) -> dict[str, Any]:
        """Fields for JSON."""
        return asdict(self)


def save_run(
    experiment: Experiment, outcome: Outcome, folder: Path, streamed: ResultFiles | None = None
) -> Report:
    """Write result files (unless streamed during the run), plot and summary.json; give the summary."""
    compare, result = experiment.compare, outcome.result
    written = streamed or write_result(result, folder)
    files = {"csv": str(written.csv), "parquet": str(written.parquet)}
    metrics: Metrics = {}
    if compare is not None:
        metrics = compute_metrics(result, compare)
        title = " / ".join(filter(None, (experiment.name, experiment.variant, outcome.status)))
        files["plot"] = str(plot_run(result, compare, title, folder / "displacement_and_force.png"))
    files["summary"] = str(folder / "summary.json")
    report = _summarise(experiment, outcome, files, metrics)
    Path(files["summary"]).write_text(json.dumps(report.as_dict(), indent=2) + "\n", encoding="utf-8")
    return report


def _summarise(experiment: Experiment, outcome: Outcome, files: dict[str, str], metrics: Metrics) -> Report:
    t_end = experiment.grid.time(outcome.steps)
    ran = outcome.steps > 0 and outcome.seconds > 0.0
    return Report(
        name=experiment.name,
        variant=experiment.variant,
        status=outcome.status,
        t_end=t_end,
        steps=outcome.steps,
        us_per_step=1e6 * outcome.seconds / outcome.steps if ran else None,
        realtime_factor=(t_end - experiment.grid.t0) / outcome.seconds if ran else None,
        files=files,
        metrics=metrics,
        message=_message(outcome),
        real_time=outcome.real_time,
        not_reached=outcome.not_reached,
        warnings=outcome.warnings,
        notes=experiment.notes,
    )


def _message(outcome: Outcome) -> str:
    if outcome.error is not None:
        return str(outcome.error)
    return f"{outcome.status}: {outcome.cause}" if outcome.cause else ""


_LABELS = {
    "zeta": ("damping ratio zeta", ".6f"),
    "frequency": ("frequency [Hz]", ".5f"),
    "growth_per_cycle": ("growth per cycle", ".4f"),
    "rms_s_des": ("rms of the simulated motion, relative to the offset", ".5f"),
    "rms_s_act": ("rms of the reproduced motion, relative to the offset", ".5f"),
    "phase_deg": ("phase of the reproduced motion [deg]", ".3f"),
    "zeta_reference": ("damping ratio of the reference", ".6f"),
    "frequency_reference": ("frequency of the reference [Hz]", ".5f"),
}


def summary_lines(report: Report) -> list[str]:
    """Summary for a terminal."""
    title = report.name if report.variant is None else f"{report.name}, variant {report.variant}"
    lines = [f"{title}: {report.status} at t = {report.t_end:g} s after {report.steps} steps"]
    if report.us_per_step is not None and report.realtime_factor is not None:
        speed = f"{report.us_per_step:.1f} us a step, {report.realtime_factor:.1f} times real time"
        lines.append(f"  {'speed':<54}{speed}")
    for key, value in report.metrics.items():
        label, form = _LABELS[key]
        lines.append(f"  {label:<54}{'-' if value is None else format(value, form)}")
    lines += [f"  {'an event that did not happen: when':<54}{text}" for text in report.not_reached]
    lines += [f"  warning: {text}" for text in report.warnings]
    lines += [f"  note: {note}" for note in report.notes]
    lines += _real_time_lines(report.real_time or {})
    return lines + [f"  {kind:<54}{path}" for kind, path in report.files.items()]


def _real_time_lines(found: dict[str, Any]) -> list[str]:
    """Lateness of the ticks, with a bar for each bin of the histogram."""
    if not found:
        return []
    worst = f"{found['worst_ms']:.3f} at tick {found['worst_tick']}"
    lines = [
        f"  {'lateness of a tick, median / 99 % [ms]':<54}{found['median_ms']:.3f} / {found['p99_ms']:.3f}",
        f"  {'worst lateness [ms]':<54}{worst}",
        f"  {'ticks that were not done in time':<54}{found['overruns']}",
    ]
    total = sum(found["histogram"].values())
    for name, count in found["histogram"].items():
        lines.append(f"    {name:>18} {count:>9} {'#' * round(40 * count / total)}".rstrip())
    return lines
