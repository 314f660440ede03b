"""What a system as one FMU cannot do: refused by name before anything is generated."""

from __future__ import annotations

from collections.abc import Iterator

from master.errors import ConfigError, Problem
from master.experiment.experiment import Experiment
from master.fmi.description import Kind
from master.stepping.machine.program import Program

MOST_OPERATIONS = 20_000  # straight-line C of more takes a compiler minutes


def refuse(experiment: Experiment) -> None:
    """
    Refuse what only a master does during a run.

    Raises:
        ConfigError: With every reason.
    """
    problems = list(_problems(experiment))
    if problems:
        raise ConfigError(problems)


def _problems(experiment: Experiment) -> Iterator[Problem]:
    if experiment.scenario.events:
        n = len(experiment.scenario.events)
        yield Problem(
            "a system as one FMU has no events: its importer sets inputs and tunable parameters",
            where="events",
            got=str(n),
            expected="none",
        )
    for name in experiment.system.connectors:
        yield Problem(
            "inputs and outputs of the system itself cannot be exported yet",
            where="connectors",
            got=repr(name),
            expected="connections between FMUs; unconnected inputs of FMUs are inputs of the FMU as they are",
        )
    for wire in experiment.system.wires:
        if Kind.STRING in (wire.source.variable.kind, wire.target.variable.kind):
            yield Problem(
                "a connection of strings", where="connections", got=wire.target.name, expected="numbers"
            )


def refuse_long_program(program: Program) -> None:
    """Refuse a tick of more operations than a compiler is asked to take, as long windows have."""
    n = len(program.operations)
    if n > MOST_OPERATIONS:
        raise ConfigError(
            [
                Problem(
                    "too many operations in a tick",
                    where="coupling.order",
                    got=str(n),
                    expected=f"at most {MOST_OPERATIONS}, with a shorter window or fewer FMUs",
                )
            ]
        )
