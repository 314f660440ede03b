"""
How an FMU that identifies answers with what it has learned: linear once its parameters stand still.

The system runs; the FMU stays as the run leaves it, is told to hold its parameters, and is asked.
"""

from __future__ import annotations

from dataclasses import replace

from master.experiment.experiment import Experiment
from master.fmi.slave import Slave
from master.fmi.values import parse
from master.stepping.outcome import RunOptions
from master.stepping.simulate import SlaveFactory, running
from master.system.graph import Instance, System

from .responses import Question, Responses, measure_running

REASON = "identification is not linear: its process parameters stay as a run leaves them"


def hold_of(instance: Instance) -> str | None:
    """Return the parameter that stops an FMU from learning; None if it does not learn as it is set."""
    variables = instance.description.by_name
    for learning in instance.description.learning:
        chosen = parse(variables[learning.by], learning.item)
        if instance.value_of(learning.by) == chosen and instance.value_of(learning.held_by) == 0.0:
            return learning.held_by
    return None


def learns(instance: Instance) -> bool:
    """Whether an FMU identifies and can be told to stop."""
    return hold_of(instance) is not None


def holding(instance: Instance) -> Instance:
    """Return an FMU that identifies, told from its start not to."""
    hold = hold_of(instance)
    return instance if hold is None else replace(instance, start={**instance.start, hold: 1.0})


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
        hold_now(question.instance, slaves[name])
        return measure_running(replace(question, t0=float(outcome.result.time[-1])), slaves[name])


def hold_now(instance: Instance, slave: Slave) -> None:
    """Tell a running FMU to stop learning."""
    hold = hold_of(instance)
    if hold is not None:
        slave.set([instance.description.by_name[hold]], [1.0])
