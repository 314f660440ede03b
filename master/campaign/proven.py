"""Runs in the fused form as long as it has the bits of the FMUs: compared at first, and now and then."""

from __future__ import annotations

from contextlib import closing

import numpy as np

from master.experiment.experiment import Experiment
from master.fuse.runs import REFUSED, FusedForm, FusedRuns
from master.stepping.outcome import COMPLETED, DIVERGED, Outcome

from .fused import NOT_YET
from .plan import Plan

NOT_EXACT = "the fused form does not have the bits of the FMUs' own binaries"
FIRST = "before a completed run of the process has shown the bits of the fused form"
COMPARED = "made both ways to compare the bits again"
NO_MEMORY = "no memory for the fused form"
"""Why runs are not made in the fused form although there is one."""

EVERY = 500
"""Runs in the fused form after which a process compares again: below 1 % of the time of most campaigns."""


class ProvenRuns:
    """
    The runs of a process that are made in the fused form.

    `form` is the form, or says why there is none, or none any more.
    """

    def __init__(self, plan: Plan, form: FusedForm | str = NOT_YET) -> None:
        self.form = form
        self._plan = plan
        self._runs: FusedRuns | None = None
        self._n_since = 0

    def run(self, experiment: Experiment) -> Outcome | str:
        """Make a run in the fused form, or return why it is to be made with the FMUs."""
        if isinstance(self.form, str):
            return self.form
        if self._runs is None:
            return FIRST
        if self._n_since >= EVERY:
            return COMPARED
        try:
            found = self._runs.run(experiment)
        except MemoryError:
            self._end(NO_MEMORY)
            return NO_MEMORY
        self._n_since += isinstance(found, Outcome)
        return found

    def learn(self, experiment: Experiment, apart: Outcome, why: str) -> str:
        """
        Learn from a run that was made with the FMUs; return why it was, in the light of how it ended.

        Args:
            experiment: The run.
            apart: How it ended.
            why: What `run` returned.
        """
        may_be_compared = apart.status in ((COMPLETED,) if self._runs is None else (COMPLETED, DIVERGED))
        if why == REFUSED and apart.status in (COMPLETED, DIVERGED):
            self._end(NOT_EXACT)
        elif why in (FIRST, COMPARED) and may_be_compared:
            self._compare(experiment, apart)
        else:
            return why
        return self.form if isinstance(self.form, str) else why

    def close(self) -> None:
        """Free the memory of the system."""
        if self._runs is not None:
            self._runs.close()
            self._runs = None

    def _compare(self, experiment: Experiment, expected: Outcome) -> None:
        """Go on in the fused form only if it makes this run with the same bits in all rows of all outputs."""
        assert isinstance(self.form, FusedForm)
        try:
            with closing(FusedRuns(self.form, self._plan.base)) as runs:
                found = runs.run(experiment)
                if found == REFUSED or (isinstance(found, Outcome) and not _is_same(found, expected)):
                    self._end(NOT_EXACT)
                elif isinstance(found, str):
                    self._end(found)
            if self._runs is None and isinstance(self.form, FusedForm):
                self._runs = FusedRuns(self.form, self._plan.base, _wanted(self._plan))
        except OSError as error:
            self._end(f"the library of the fused form cannot be loaded: {error}")
        except MemoryError:
            self._end(NO_MEMORY)
        self._n_since = 0

    def _end(self, why: str) -> None:
        self.close()
        self.form = why


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
