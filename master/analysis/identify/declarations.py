"""What an FMU declares of itself and its responses cannot tell: when it is not linear, varies or learns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from master.fmi.linearity import DeclaredLearning, DeclaredLinear
from master.fmi.slave import Slave
from master.fmi.values import parse
from master.system.graph import Instance
from master.text.scalar import Plain


def departures(instance: Instance) -> Iterator[DeclaredLinear]:
    """Return, for each parameter with which an FMU is not linear and constant, the value to give it."""
    choices: dict[str, list[DeclaredLinear]] = {}
    for declared in instance.description.linear:
        choices.setdefault(declared.parameter, []).append(declared)
    for parameter, declared_values in choices.items():
        variable = instance.description.by_name[parameter]
        values = [parse(variable, Plain(one.value)) for one in declared_values]
        if instance.value_of(parameter) not in values:
            yield declared_values[0]


def learning_of(instance: Instance) -> DeclaredLearning | None:
    """Return how an FMU learns as it is set; None if it does not, or is held."""
    variables = instance.description.by_name
    for learning in instance.description.learning:
        chosen = parse(variables[learning.by], Plain(learning.item))
        if instance.value_of(learning.by) == chosen and instance.value_of(learning.held_by) == 0.0:
            return learning
    return None


def learns(instance: Instance) -> bool:
    """Whether an FMU learns and can be told to stop."""
    return learning_of(instance) is not None


def holding(instance: Instance) -> Instance:
    """Return an FMU that learns, told from its start not to."""
    learning = learning_of(instance)
    return (
        instance if learning is None else replace(instance, start={**instance.start, learning.held_by: 1.0})
    )


def hold_now(instance: Instance, slave: Slave) -> None:
    """Tell a running FMU to stop learning."""
    learning = learning_of(instance)
    if learning is not None:
        slave.set([instance.description.by_name[learning.held_by]], [1.0])
