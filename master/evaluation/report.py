"""What a run leaves behind: files in a folder, and a summary for people and for programs."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from importlib import import_module
from typing import Any

from master.experiment.experiment import Experiment
from master.fmi.messages import Said
from master.process.signals import Interruption
from master.recording.files import ResultFiles, existing, write_result
from master.recording.folder import LOG, PICTURE, SUMMARY, OutputFolder, reason
from master.recording.whole_file import write_whole
from master.stepping.outcome import COMPLETED, FAILED, INTERRUPTED, STOPPED, TERMINATED, Happened, Outcome

from .metrics import Metrics, compute_metrics
from .run_charts import plot_run

MoreFiles = Callable[[Outcome, OutputFolder], dict[str, str]]
"""Writes files into the folder of a run; returns them by kind."""

_LIBRARIES = ("pyarrow.csv", "pyarrow.parquet", "matplotlib.figure", "matplotlib.backends.backend_agg")


def load_libraries() -> None:
    """Load what saving and drawing need, which takes longer than either."""
    for name in _LIBRARIES:
        import_module(name)


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
    happened: list[Happened] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    messages: list[Said] = field(default_factory=list)

    def as_dict(self) -> dict[str, Any]:
        """Fields for JSON."""
        return asdict(self)


def save_run(
    experiment: Experiment,
    outcome: Outcome,
    folder: OutputFolder,
    streamed: ResultFiles | None = None,
    interruption: Interruption | None = None,
    more: MoreFiles | None = None,
) -> Report:
    """
    Write result files (or end those streamed during the run), picture and summary.json; return the summary.

    What the disk does not take is said in the summary, whose status is `failed` then; a run that is
    interrupted while it is saved is `interrupted`. `more` writes what else belongs into the folder, when the
    rows are there.
    """
    files, fault = _save_rows(experiment, outcome, folder, streamed)
    if os.path.exists(folder.path / LOG):
        files["log"] = str(folder.shown / LOG)
    if fault and outcome.error is None:
        outcome = replace(outcome, status=FAILED, cause=fault)
    metrics, notes = _evaluated(experiment, outcome, files, folder, draws=not (fault or interruption))
    if interruption and outcome.status in (COMPLETED, STOPPED, TERMINATED):
        outcome = replace(outcome, status=INTERRUPTED)
    notes = [*experiment.notes, *notes] + ([fault] if fault and outcome.error is not None else [])
    if more is not None:
        written, said = _written(more, outcome, folder)
        files |= written
        notes += said
    report = replace(_summarise(experiment, outcome, files, metrics), notes=notes)
    return _write_summary(report, folder)


def _written(more: MoreFiles, outcome: Outcome, folder: OutputFolder) -> tuple[dict[str, str], list[str]]:
    """Write further files; a note where the disk does not take them."""
    try:
        return more(outcome, folder), []
    except OSError as error:
        return {}, [f"{folder.shown}: cannot be written: {reason(error)}"]


def _save_rows(
    experiment: Experiment, outcome: Outcome, folder: OutputFolder, streamed: ResultFiles | None
) -> tuple[dict[str, str], str]:
    """Save all rows; return the files that exist, and what went wrong."""
    fault = outcome.storage_fault
    place = folder.shown
    try:
        if not folder.takes_files():
            said = "removed during the run" if folder.vanished() else "the folder takes no files any more"
            fault = fault or said
            folder.secure()
        if streamed is None:
            write_result(experiment.selection.of(outcome.result), folder.shown)
        elif fault:
            streamed.rescue(folder.shown)
        else:
            streamed.close()
    except OSError as error:
        fault = fault or reason(error)
        folder.make_room()
        if streamed is not None:
            with suppress(OSError):
                streamed.rescue(folder.shown)
    where = f"{place}: results cannot be written whole: {fault}"
    if folder.shown != place:
        where += f"; what could not be written there is in {folder.shown}"
    return existing(place) | existing(folder.shown), where if fault else ""


def _evaluated(
    experiment: Experiment, outcome: Outcome, files: dict[str, str], folder: OutputFolder, *, draws: bool
) -> tuple[Metrics, list[str]]:
    """Metrics where motions are compared, and the picture; notes on what could not be drawn."""
    compare, result = experiment.compare, outcome.result
    if not len(result.time):
        return {}, []
    metrics = {} if compare is None else compute_metrics(result, compare)
    if not draws or not experiment.draws:
        return metrics, []
    try:
        files["plot"] = str(plot_run(experiment, outcome, folder.shown / PICTURE))
    except Exception as error:  # whatever a library finds in names and values: the results are there
        return metrics, [f"{PICTURE} cannot be drawn: {' '.join(str(error).split()) or type(error).__name__}"]
    return metrics, []


def _write_summary(report: Report, folder: OutputFolder) -> Report:
    path = folder.shown / SUMMARY
    report = replace(report, files={**report.files, "summary": str(path)})
    folder.make_room()
    try:
        write_whole(path, json.dumps(report.as_dict(), indent=2) + "\n")
    except OSError as error:
        files = {kind: file for kind, file in report.files.items() if kind != "summary"}
        said = f"{path}: cannot be written: {reason(error)}"
        message = "\n".join(filter(None, (report.message, said)))
        return replace(report, status=FAILED, files=files, message=message)
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
        happened=outcome.happened,
        warnings=outcome.warnings,
        notes=experiment.notes,
        messages=outcome.messages,
    )


def _message(outcome: Outcome) -> str:
    if outcome.error is not None:
        return str(outcome.error)
    return f"{outcome.status}: {outcome.cause}" if outcome.cause else ""


_MOST_MESSAGES = 10
_MOST_WORST = 3
_LONGEST_MESSAGE = 300

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
    lines += [f"  {'an event happened when':<54}{h.condition} at t = {h.t:.9g} s" for h in report.happened]
    lines += [f"  {'an event that did not happen: when':<54}{text}" for text in report.not_reached]
    lines += [f"  warning: {text}" for text in report.warnings]
    lines += [f"  note: {note}" for note in report.notes]
    lines += _message_lines(report.messages)
    lines += _real_time_lines(report.real_time or {})
    return lines + [f"  {kind:<54}{path}" for kind, path in report.files.items()]


def _message_lines(messages: list[Said]) -> list[str]:
    """Warnings and errors of FMUs, the worst first."""
    worst_first = sorted(messages, key=lambda said: said.status == "warning")
    lines = []
    for said in worst_first[:_MOST_MESSAGES]:
        when = "" if said.t is None else f" at t = {said.t:.9g} s"
        times = "" if said.count == 1 else f", {said.count} times"
        category = f"[{said.category}] " if said.category else ""
        lines.append(f"  {said.status} of {said.fmu}{when}{times}: {category}{said.text[:_LONGEST_MESSAGE]}")
    if len(messages) > _MOST_MESSAGES:
        lines.append(f"  ... and {len(messages) - _MOST_MESSAGES} more messages of FMUs, in {SUMMARY}")
    return lines


def _real_time_lines(found: dict[str, Any]) -> list[str]:
    """Lateness of the ticks, with a bar for each bin of the histogram."""
    if not found:
        return []
    shares = " / ".join(f"{found[key]:.3f}" for key in ("median_ms", "p99_ms", "p999_ms"))
    lines = [
        f"  {'lateness of a tick, median / 99 % / 99.9 % [ms]':<54}{shares}",
        f"  {'ticks that were not done in time':<54}{found['overruns']}",
    ]
    if found["page_faults"] is not None:
        lines.append(f"  {'page faults after the first second':<54}{found['page_faults']}")
    for worst in found["worst"][:_MOST_WORST]:
        said = f"{worst['late_ms']:.3f} at tick {worst['tick']}: {worst['cause']}"
        lines.append(f"  {'among the worst latenesses [ms]':<54}{said}")
    lines += [f"  note: {note}" for note in found["notes"]]
    total = sum(found["histogram"].values())
    for name, count in found["histogram"].items():
        lines.append(f"    {name:>18} {count:>9} {'#' * round(40 * count / total)}".rstrip())
    return lines
