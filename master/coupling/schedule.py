"""Who steps when: the coupling order, checked and completed, independent of hashing and dictionaries."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from graphlib import CycleError, TopologicalSorter

from master.errors import ConfigError, expected
from master.system.graph import System, Wire

from .methods.catalogue import method_of
from .methods.method import Method


@dataclass(frozen=True)
class Schedule:
    """
    Groups that step one after the other, each with the newest values of those before it.

    `every`: for each instance the number of ticks from one update of its outputs to the next. An instance
    that updates at every n-th tick does so at the last of the n ticks, so that no row holds a value of a
    later time.
    """

    groups: tuple[Method, ...]
    every: Mapping[str, int]

    @classmethod
    def of(cls, groups: Iterable[Method], every: Mapping[str, int]) -> Schedule:
        """Schedule groups whose instances step every n-th tick."""
        groups = tuple(groups)
        return cls(groups, {name: every[name] * g.ticks for g in groups for name in g.members})

    @property
    def order(self) -> list[str]:
        """All instances, group after group."""
        return [name for group in self.groups for name in group.members]

    @property
    def members(self) -> tuple[tuple[str, ...], ...]:
        """Members of each group."""
        return tuple(group.members for group in self.groups)

    @property
    def initial_passes(self) -> int:
        """Passes over the wires that solve algebraic loops within groups at the start."""
        return max((group.initial_passes for group in self.groups), default=0)

    @cached_property
    def _place(self) -> dict[str, int]:
        return {name: i for i, group in enumerate(self.groups) for name in group.members}

    def group_of(self, instance: str) -> int:
        """Place of the instance's group in the order."""
        return self._place[instance]

    def closes(self, wire: Wire) -> bool:
        """Whether a wire lies within a group that iterates until its ends agree."""
        return self._within(wire) and self.groups[self.group_of(wire.source.instance)].closes(wire)

    def tolerance_of(self, wire: Wire) -> float:
        """How far the ends of a wire may be apart, in the target's unit; 0 where it is not iterated."""
        return (
            self.groups[self.group_of(wire.source.instance)].tolerance_of(wire) if self.closes(wire) else 0.0
        )

    def age(self, wire: Wire) -> int:
        """Age in rows that the order gives a value when it is used: 0 along the order, 1 against it."""
        source, target = self.group_of(wire.source.instance), self.group_of(wire.target.instance)
        if source == target:
            return self.groups[source].age(wire)
        return 0 if source < target else 1

    def event_faults(self, system: System, targets: Collection[str]) -> list[str]:
        """List the connected inputs under events, of those given, on which events cannot act."""
        return [fault for group in self.groups for fault in group.event_faults(system, targets)]

    def _within(self, wire: Wire) -> bool:
        return self.group_of(wire.source.instance) == self.group_of(wire.target.instance)


def make_schedule(system: System, order: Sequence[str | list[str] | Method] | None, where: str) -> Schedule:
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
        return Schedule.of(map(method_of, _along_wires(system, where)), every)
    groups = [method_of(entry) for entry in order]
    problems = _order_faults([g.members for g in groups], list(system.instances), where)
    problems += [fault for group in groups for fault in group.faults(system, where)]
    if problems:
        raise ConfigError(problems)
    return Schedule.of(groups, every)


def _along_wires(system: System, where: str) -> list[str]:
    before: dict[str, list[str]] = {name: [] for name in system.instances}
    for wire in system.wires:
        if not wire.delay:
            before[wire.target.instance].append(wire.source.instance)
    try:
        return list(TopologicalSorter(before).static_order())
    except CycleError as error:
        loop = " -> ".join(reversed(error.args[1]))
        raise ConfigError(
            [f"{where}: missing although the system has a loop, got {loop}, expected the order of stepping"]
        ) from None


def _order_faults(groups: Sequence[Sequence[str]], names: list[str], where: str) -> list[str]:
    flat = [name for group in groups for name in group]
    faults = [f"{where}: no such FMU, got {n!r}, {expected(n, names)}" for n in flat if n not in names]
    faults += [
        f"{where}: stands twice, got {n!r}, expected each FMU once" for n in names if flat.count(n) > 1
    ]
    missing = [n for n in names if n not in flat]
    if missing:
        faults.append(f"{where}: incomplete, got no {', '.join(missing)}, expected every FMU once")
    return faults
