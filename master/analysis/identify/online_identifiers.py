"""
How an FMU that learns answers with what it has learned: linear once its parameters stay as they are.

The system runs; the FMU stays as the run leaves it, is told to hold its parameters, and is asked.
"""

from __future__ import annotations

from dataclasses import replace

from master.experiment.experiment import Experiment
from master.stepping.outcome import RunOptions
from master.stepping.simulate import SlaveFactory, running
from master.system.graph import System

from .declarations import hold_now
from .responses import Question, Responses, measure_running


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
