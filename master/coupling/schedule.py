"""Who steps when: the coupling order, checked and completed, independent of hashing and dictionaries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from graphlib import CycleError, TopologicalSorter

from master.errors import ConfigError, expected
from master.system.config import IteratedGroup
from master.system.graph import System, Wire


@dataclass(frozen=True)
class Iteration:
    """When an iterated group is done: tolerance relative to nominal values, most passes."""

    tolerance: float
    maximum: int


@dataclass(frozen=True)
class Schedule:
    """
    Groups that step one after the other.

    The members of a group step side by side, or, where `iterations` has the group's place, one after
    the other until their wires agree.
    `every` says for each instance how many ticks one of its steps covers. An instance that steps every
    n-th tick does so at the last of the n ticks, so that no row holds a value of a later time.
    """

    groups: tuple[tuple[str, ...], ...]
    every: Mapping[str, int]
    iterations: Mapping[int, Iteration] = field(default_factory=dict)

    def group_of(self, instance: str) -> int:
        """Place of the instance's group in the order."""
        return next(i for i, group in enumerate(self.groups) if instance in group)

    def is_iterated(self, wire: Wire) -> bool:
        """Whether a wire lies within an iterated group and is closed there."""
        group = self.group_of(wire.source.instance)
        return group in self.iterations and wire.target.instance in self.groups[group] and not wire.delay

    def tolerance_of(self, wire: Wire) -> float:
        """How far the ends of a wire may stand apart, in the target's unit; 0 where it is not iterated."""
        if not self.is_iterated(wire):
            return 0.0
        iteration = self.iterations[self.group_of(wire.source.instance)]
        tolerance = iteration.tolerance if wire.tolerance is None else wire.tolerance
        return tolerance * (wire.target.variable.nominal or 1.0)


def make_schedule(
    system: System, order: Sequence[str | list[str] | IteratedGroup] | None, where: str
) -> Schedule:
    """
    Complete and check the coupling order.

    Args:
        system: The graph.
        order: From the configuration; None: along the wires, the file's order where they leave it open.
        where: Place of the order in the file, for messages.

    Raises:
        ConfigError: If an FMU is missing, unknown or twice in the order, or there is a loop and no order.
    """
    every = {name: i.every for name, i in system.instances.items()}
    if order is None:
        return Schedule(_along_wires(system, where), every)
    groups = tuple(_members(entry) for entry in order)
    problems = _order_faults(groups, list(system.instances), where)
    iterations = {
        i: Iteration(entry.tolerance, entry.maximum)
        for i, entry in enumerate(order)
        if isinstance(entry, IteratedGroup)
    }
    problems += [f for i in iterations for f in _iteration_faults(system, groups[i], where)]
    if problems:
        raise ConfigError(problems)
    return Schedule(groups, every, iterations)


def _members(entry: str | list[str] | IteratedGroup) -> tuple[str, ...]:
    if isinstance(entry, IteratedGroup):
        return tuple(entry.iterate)
    return (entry,) if isinstance(entry, str) else tuple(entry)


def _iteration_faults(system: System, group: tuple[str, ...], where: str) -> list[str]:
    members = [system.instances[name] for name in group if name in system.instances]
    faults = [
        f"{where}: {i.name} cannot be iterated, got an FMU that does not save its state"
        for i in members
        if not i.description.can_get_and_set_state
    ]
    faults += [
        f"{where}: an iterated connection is not extrapolated, got {w.source.name} -> {w.target.name}"
        for w in system.wires
        if w.extrapolation and not w.delay and {w.source.instance, w.target.instance} <= set(group)
    ]
    faults += [
        f"{where}: an iterated connection has no map, got {w.source.name} -> {w.target.name}"
        for w in system.wires
        if not (w.conversion.is_affine or w.delay) and {w.source.instance, w.target.instance} <= set(group)
    ]
    rates = {i.every for i in members}
    if len(rates) > 1:
        faults.append(f"{where}: an iterated group has one rate, got every {sorted(rates)} ticks")
    return faults


def _along_wires(system: System, where: str) -> tuple[tuple[str, ...], ...]:
    before: dict[str, list[str]] = {name: [] for name in system.instances}
    for wire in system.wires:
        if not wire.delay:
            before[wire.target.instance].append(wire.source.instance)
    try:
        order = list(TopologicalSorter(before).static_order())
    except CycleError as error:
        loop = " -> ".join(reversed(error.args[1]))
        raise ConfigError(
            [f"{where}: missing although the system has a loop, got {loop}, expected the order of stepping"]
        ) from None
    return tuple((name,) for name in order)


def _order_faults(groups: tuple[tuple[str, ...], ...], names: list[str], where: str) -> list[str]:
    flat = [name for group in groups for name in group]
    faults = [f"{where}: no such FMU, got {n!r}, {expected(n, names)}" for n in flat if n not in names]
    faults += [
        f"{where}: stands twice, got {n!r}, expected each FMU once" for n in names if flat.count(n) > 1
    ]
    missing = [n for n in names if n not in flat]
    if missing:
        faults.append(f"{where}: incomplete, got no {', '.join(missing)}, expected every FMU once")
    return faults
