"""Runs one after the other in this process; FMUs stay loaded as long as systems differ in values alone."""

from __future__ import annotations

from master.experiment.experiment import Experiment
from master.stepping.kept import KeptSystem
from master.stepping.outcome import Outcome, RunOptions


class KeptRuns:
    """
    Makes runs of experiments, each with the bits of `simulate`.

    `is_spent`: the last run ended with the fatal status of an FMU; nothing of these FMUs may be called again.
    """

    def __init__(self) -> None:
        self._kept: KeptSystem | None = None
        self._kept_for: Experiment | None = None

    @property
    def is_spent(self) -> bool:
        """Whether an FMU of the last run ended with a fatal status."""
        return self._kept is not None and self._kept.is_spent

    def run(self, experiment: Experiment) -> Outcome:
        """
        Step an experiment to its end; the rows of the outcome are good until the next run.

        Raises:
            FmuError: If an FMU cannot be loaded or initialised; later failures are in the outcome.
        """
        options = RunOptions(
            limits=experiment.limits,
            compared=experiment.compared,
            scenario=experiment.scenario,
            inputs=experiment.inputs,
        )
        return self._system(experiment).run(experiment.system, experiment.grid, options)

    def close(self) -> None:
        """End the FMUs."""
        if self._kept is not None and not self._kept.is_spent:
            self._kept.close()
        self._kept = None

    def _system(self, experiment: Experiment) -> KeptSystem:
        kept = self._kept
        is_alike = self._kept_for is not None and _is_alike(self._kept_for, experiment)
        if kept is not None and is_alike and not kept.is_spent:
            return kept
        self.close()
        self._kept = KeptSystem(experiment.schedule)
        self._kept_for = experiment
        return self._kept


def _is_alike(one: Experiment, other: Experiment) -> bool:
    """Whether two systems differ in values alone, so that the same FMUs and program serve both."""
    if one.schedule is other.schedule and one.system.wires is other.system.wires:
        return True
    files = [
        [(name, i.description.path, i.every) for name, i in e.system.instances.items()] for e in (one, other)
    ]
    return files[0] == files[1] and (one.schedule, one.system.wires) == (other.schedule, other.system.wires)
