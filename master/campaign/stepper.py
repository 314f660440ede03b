"""The runs of a campaign in one process: FMUs stay loaded, a row of numbers comes out of each run."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from master.errors import ConfigError, FmuError, MasterError
from master.experiment.experiment import Experiment
from master.fuse.runs import FusedForm
from master.recording.recorder import Result
from master.runs.kept_runs import KeptRuns
from master.stepping.outcome import DIVERGED, FAILED, Outcome
from master.stepping.recorded import recorded_ports

from .fused import FUSED, NOT_YET
from .measures import Function, load_function, measured, metrics
from .plan import Plan
from .proven import NOT_EXACT, ProvenRuns
from .systems import Systems

TIMED_OUT, CRASHED = "timed_out", "crashed"
"""Statuses of runs that took their process along, next to those of `dockloop run`."""

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

    `is_spent`: an FMU ended with a fatal status, and this process can make no more runs. `proven` makes
    those in the fused form.
    """

    def __init__(self, plan: Plan, form: FusedForm | str = NOT_YET) -> None:
        threadpool_limits(1)  # as many processes as cores: more threads would only wait for each other
        self.is_spent = False
        self._plan = plan
        self._systems = Systems(plan.varied)
        self._runs = KeptRuns()
        self.proven = ProvenRuns(plan, form)
        self._n_recorded = len(recorded_ports(plan.base.system))
        self._functions = _functions(plan)

    def row(self, run: int, more: Mapping[str, Any] | None = None, *, is_apart: bool = False) -> Row:
        """
        Make a run.

        Args:
            run: Its number in the sample.
            more: Values over those of the sample.
            is_apart: Whether it is made with the FMUs apart as the fused form has shown other bits elsewhere.
        """
        began = time.perf_counter()
        values = {**self._plan.values(run), **(more or {})}
        why_apart = ""
        try:
            experiment = self._systems.experiment(values)
            found = NOT_EXACT if is_apart else self.proven.run(experiment)
            is_fused = isinstance(found, Outcome)
            if isinstance(found, Outcome):
                outcome = found
            else:
                why_apart = found
                outcome = self._runs.run(experiment)
                self.is_spent = self._runs.is_spent
                why_apart = self.proven.learn(experiment, outcome, why_apart)
        except MasterError as error:  # of this run alone
            text = "; ".join(error.problems) if isinstance(error, ConfigError) else str(error)
            if isinstance(error, FmuError):
                self.is_spent = self._runs.is_spent
            return Row(run, FAILED, text, time.perf_counter() - began, values=values, made=why_apart)
        n_recorded = self._n_recorded if is_fused else outcome.result.values.shape[1]
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
            FUSED if is_fused else why_apart,
        )

    def close(self) -> None:
        """End the FMUs."""
        self._runs.close()
        self.proven.close()

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


def _functions(plan: Plan) -> dict[str, Function]:
    return {
        name: load_function(measure.function, plan.folder)
        for name, measure in plan.measures.items()
        if measure.function is not None
    }
