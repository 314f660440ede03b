"""What a system as one FMU cannot do: refused by name before anything is generated."""

from __future__ import annotations

from collections.abc import Iterator

from master.errors import ConfigError, Problem
from master.experiment.experiment import Experiment
from master.fmi.description import Kind
from master.stepping.machine.program import Program
from master.system.graph import System

from .layout import connector_start

MOST_OPERATIONS = 20_000  # straight-line C of more takes a compiler minutes


def refuse(experiment: Experiment, *, is_exported: bool) -> None:
    """
    Refuse what only a master does during a run.

    Args:
        experiment: The system.
        is_exported: Whether it becomes an FMU; else a library for whole runs.

    Raises:
        ConfigError: With every reason.
    """
    problems = list(_problems(experiment, is_exported=is_exported))
    if problems:
        raise ConfigError(problems)


def _problems(experiment: Experiment, *, is_exported: bool) -> Iterator[Problem]:
    yield from _of_connectors(experiment.system, is_exported=is_exported)
    for wire in experiment.system.wires:
        if Kind.STRING in (wire.source.variable.kind, wire.target.variable.kind):
            yield Problem(
                "a connection of strings", where="connections", got=wire.target.name, expected="numbers"
            )


def _of_connectors(system: System, *, is_exported: bool) -> Iterator[Problem]:
    for owner, description in system.connectors.items():
        if not is_exported:
            yield Problem(
                "runs of a system with inputs and outputs of its own are not fused",
                where="connectors",
                got=repr(owner),
                expected="connections between FMUs",
            )
            continue
        for v in description.variables:
            name = f"{owner}.{v.name}"
            if v.kind is Kind.STRING or v.causality not in ("input", "output"):
                kind = "a text" if v.kind is Kind.STRING else f"a {v.causality}"
                expected = "inputs and outputs that are numbers; FMUs' parameters are parameters as they are"
                yield Problem(f"{kind} of the system itself", where="connectors", got=name, expected=expected)
            elif v.causality == "input" and connector_start(system, name) is None:
                yield Problem(
                    "no value from which all that it leads to start as they do",
                    where="connectors",
                    got=name,
                    expected="a start value of the input",
                )

    for wire in system.inlets:
        if wire.target.instance in system.instances and wire.target.variable.causality != "input":
            yield Problem(
                "an input of the system itself leads to what is no input",
                where="connectors",
                got=wire.target.name,
                expected="inputs of FMUs",
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
