"""
How an FMU that identifies answers with what it has learned: linear once its parameters stand still.

The system runs; the FMU stays as the run leaves it, is told to hold its parameters, and is asked.
"""

from __future__ import annotations

from dataclasses import replace

from master.experiment.experiment import Experiment
from master.fmi.values import parse
from master.stepping.outcome import RunOptions
from master.stepping.simulate import SlaveFactory, running
from master.system.graph import Instance, System

from .responses import Question, Responses, measure_running

HOLD = "identification_held"
REASON = "identification is not linear: its process parameters stay as a run leaves them"


def learns(instance: Instance) -> bool:
    """Whether an FMU identifies and can be told to stop."""
    names = instance.description.by_name
    return HOLD in names and instance.value_of(HOLD) == 0.0 and not _is_fixed(instance)


def holding(instance: Instance) -> Instance:
    """Give an FMU that identifies, told from its start not to."""
    return replace(instance, start={**instance.start, HOLD: 1.0})


def _is_fixed(instance: Instance) -> bool:
    identifier = instance.description.by_name.get("identifier")
    return identifier is not None and instance.value_of("identifier") == parse(identifier, "fixed")


def measure_learned(
    question: Question, experiment: Experiment, system: System, factory: SlaveFactory
) -> Responses:
    """
    Ask an FMU after a run of its system, constant in time, which may end early by the experiment's limits.

    Raises:
        FmuError: If the FMU fails in the run or in its answers.
    """
    name = question.instance.name
    own = replace(system, instances={**system.instances, name: question.instance})
    options = RunOptions(limits=experiment.limits, compared=experiment.compared, inputs=experiment.inputs)
    with running(own, experiment.schedule, experiment.grid, options=options, factory=factory) as run:
        outcome, slaves = run
        if outcome.error is not None and outcome.error.instance == name:
            raise outcome.error
        slaves[name].set([question.instance.description.by_name[HOLD]], [1.0])
        return measure_running(replace(question, t0=float(outcome.result.time[-1])), slaves[name])
