"""The runs of a campaign in one process: FMUs stay loaded, a row of numbers comes out of each run."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from master.errors import ConfigError, FmuError, MasterError
from master.experiment.experiment import Experiment
from master.fuse.runs import FusedForm, FusedRuns
from master.recording.recorder import Result
from master.runs.kept_runs import KeptRuns
from master.stepping.outcome import DIVERGED, FAILED, Outcome
from master.stepping.recorded import recorded_ports

from .fused import FUSED, NOT_YET
from .measures import Function, load_function, measured, metrics
from .plan import Plan
from .systems import Systems

TIMED_OUT, CRASHED = "timed_out", "crashed"
"""Statuses of runs that took their process along, next to those of `dockloop run`."""

NOT_EXACT = "the fused form does not have the bits of the FMUs' own binaries"
FIRST = "first of a process, by which the bits of the fused form are tried"
REFUSED = "refused by an FMU, which says itself what is wrong"
"""Why runs are not made in the fused form although there is one."""

FAILURES = (FAILED, CRASHED, TIMED_OUT)


@dataclass(frozen=True)
class Row:
    """
    What is kept of one run.

    `values` are those that varied, `numbers` metrics and measures (None where there is none), `signals` the
    kept rows of signals, shape (rows,). `made` is FUSED, or says why the run was made with the FMUs apart.
    """

    run: int
    status: str
    message: str = ""
    wall: float = 0.0
    stepping: float = 0.0
    t_end: float | None = None
    steps: int = 0
    values: Mapping[str, Any] = field(default_factory=dict)
    numbers: Mapping[str, float | None] = field(default_factory=dict)
    signals: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    made: str = ""

    def number(self, name: str) -> float | None:
        """Return a number by name; `diverged` is 1 or 0, and unknown of a run that failed."""
        if name == DIVERGED:
            return None if self.status in FAILURES else float(self.status == DIVERGED)
        return self.numbers.get(name)


class Stepper:
    """
    Makes runs one after the other.

    `is_spent`: an FMU ended with a fatal status, and this process can make no more runs. `form` is the fused
    form that runs are made in once it has shown the bits of the FMUs, or says why there is none.
    """

    def __init__(self, plan: Plan, form: FusedForm | str = NOT_YET) -> None:
        threadpool_limits(1)  # as many processes as cores: more threads would only wait for each other
        self.is_spent = False
        self._plan = plan
        self._systems = Systems(plan.varied)
        self._runs = KeptRuns()
        self.form = form
        self._fused: FusedRuns | None = None
        self._n_recorded = len(recorded_ports(plan.base.system))
        self._functions = _functions(plan)

    def row(self, run: int, more: Mapping[str, Any] | None = None) -> Row:
        """
        Make a run.

        Args:
            run: Its number in the sample.
            more: Values over those of the sample.
        """
        began = time.perf_counter()
        values = {**self._plan.values(run), **(more or {})}
        why_apart = self._why_apart()
        try:
            experiment = self._systems.experiment(values)
            fused = None if self._fused is None else self._fused.run(experiment)
            outcome = fused or self._apart(experiment)
        except MasterError as error:  # of this run alone
            text = "; ".join(error.problems) if isinstance(error, ConfigError) else str(error)
            if isinstance(error, FmuError):
                self.is_spent = self._runs.is_spent
            return Row(run, FAILED, text, time.perf_counter() - began, values=values, made=why_apart)
        n_recorded = outcome.result.values.shape[1] if fused is None else self._n_recorded
        numbers, faults = self._numbers(experiment, outcome.result, n_recorded)
        said = [outcome.cause, "" if outcome.error is None else str(outcome.error), *faults]
        return Row(
            run,
            outcome.status,
            "; ".join(filter(None, said)),
            time.perf_counter() - began,
            outcome.seconds,
            experiment.grid.time(outcome.steps),
            outcome.steps,
            values,
            numbers,
            _kept(outcome.result, self._plan.signals),
            why_apart if fused is None else FUSED,
        )

    def close(self) -> None:
        """End the FMUs."""
        self._runs.close()
        if self._fused is not None:
            self._fused.close()
            self._fused = None

    def _apart(self, experiment: Experiment) -> Outcome:
        """Make a run with the FMUs themselves; a form that has not been tried is tried by the way."""
        outcome = self._runs.run(experiment)
        self.is_spent = self._runs.is_spent
        if self._fused is None and isinstance(self.form, FusedForm):
            self._try(self.form, experiment, outcome)
        return outcome

    def _try(self, form: FusedForm, experiment: Experiment, expected: Outcome) -> None:
        """Let the runs that follow be made in the fused form if it makes this one with the same bits."""
        try:
            with closing(FusedRuns(form, self._plan.base)) as runs:
                found = runs.run(experiment)
                if found is None and expected.status == FAILED:
                    return  # of a run that fails nothing is to be learned
                if found is None or not _is_same(found, expected):
                    self.form = NOT_EXACT
                    return
            self._fused = FusedRuns(form, self._plan.base, _wanted(self._plan))
        except OSError as error:
            self.form = f"the library of the fused form cannot be loaded: {error}"

    def _why_apart(self) -> str:
        """Say why the next run is made with the FMUs apart, if it is."""
        if isinstance(self.form, str):
            return self.form
        return FIRST if self._fused is None else REFUSED

    def _numbers(
        self, experiment: Experiment, result: Result, n_recorded: int
    ) -> tuple[dict[str, float | None], list[str]]:
        """Compute metrics and measures, and say which function of the user failed."""
        plan = self._plan
        found: dict[str, float | None] = {}
        found |= metrics(result, experiment.compare, plan.metrics, n_recorded)
        faults: list[str] = []
        for name, measure in plan.measures.items():
            try:
                found[name] = measured(measure, result, self._functions.get(name))
            except Exception as error:  # whatever the function of a user does
                found[name] = None
                faults.append(f"{name}: {type(error).__name__}: {error}")
        return found, faults


def _kept(result: Result, signals: Mapping[str, int]) -> dict[str, NDArray[np.float64]]:
    """Return each n-th row of the signals that a run has: another method or model may have others."""
    known = set(result.names)
    return {name: result[name][::every].copy() for name, every in signals.items() if name in known}


def _is_same(one: Outcome, other: Outcome) -> bool:
    """Whether two runs ended alike, with rows of the same bits."""
    ends = [(outcome.status, outcome.steps, outcome.cause) for outcome in (one, other)]
    rows = [np.ascontiguousarray(outcome.result.values).tobytes() for outcome in (one, other)]
    return ends[0] == ends[1] and rows[0] == rows[1]


def _wanted(plan: Plan) -> set[str] | None:
    """Recorded signals that something is made of, None for all: what a user's function reads is not known."""
    if any(measure.function is not None for measure in plan.measures.values()):
        return None
    measured = {signal for measure in plan.measures.values() for signal in measure.signals}
    return {*plan.signals, *measured, *(plan.base.compared if plan.metrics else ())}


def _functions(plan: Plan) -> dict[str, Function]:
    return {
        name: load_function(measure.function, plan.folder)
        for name, measure in plan.measures.items()
        if measure.function is not None
    }
