"""Who steps when: the coupling order, checked and completed, independent of hashing and dictionaries."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter

from .errors import ConfigError, expected
from .graph import System


@dataclass(frozen=True)
class Schedule:
    """
    Groups that step one after the other; the members of a group step side by side.

    `every` says for each instance how many ticks one of its steps covers. An instance that steps every
    n-th tick does so at the last of the n ticks, so that no row holds a value of a later time.
    """

    groups: tuple[tuple[str, ...], ...]
    every: Mapping[str, int]

    def group_of(self, instance: str) -> int:
        """Place of the instance's group in the order."""
        return next(i for i, group in enumerate(self.groups) if instance in group)


def make_schedule(system: System, order: list[str | list[str]] | None, where: str) -> Schedule:
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
    groups = tuple((g,) if isinstance(g, str) else tuple(g) for g in order)
    problems = _order_faults(groups, list(system.instances), where)
    if problems:
        raise ConfigError(problems)
    return Schedule(groups, every)


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
