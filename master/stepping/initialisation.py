"""Before the first tick: start values, initialisation mode, and initial values through the wires."""

from __future__ import annotations

from collections.abc import Mapping

from master.coupling.schedule import Schedule
from master.errors import FmuError
from master.fmi.slave import Slave
from master.system.graph import System, Wire


def initialise(system: System, schedule: Schedule, slaves: Mapping[str, Slave], t0: float) -> None:
    """
    Enter initialisation, let the initial values run through the wires until they stand, and leave it.

    Each pass takes at least one wire of a path on, so that as many passes as wires settle any system
    without an algebraic loop. One within an iterated group is iterated to the group's tolerance.

    Raises:
        FmuError: If an FMU refuses, or the values do not settle.
    """
    for name, slave in slaves.items():
        slave.enter_initialisation(system.instances[name].start, t0)
    order = [name for group in schedule.groups for name in group]
    sent: dict[str, float] = {}
    for _ in range(len(system.wires) + 1 + max((i.maximum for i in schedule.iterations.values()), default=0)):
        moved = [wire for name in order for wire in _pull(system, schedule, slaves, name, sent)]
        if not moved:
            break
    else:
        names = ", ".join(f"{w.source.name} -> {w.target.name}" for w in moved)
        raise FmuError(
            moved[0].target.instance,
            f"initial values do not settle, got changes on {names}, expected no algebraic loop at the start "
            "or one that an iterated group solves",
        )
    for slave in slaves.values():
        slave.exit_initialisation()


def _pull(
    system: System, schedule: Schedule, slaves: Mapping[str, Slave], name: str, sent: dict[str, float]
) -> list[Wire]:
    """Set the inputs of one slave to its sources' present values; give the wires whose value changed."""
    moved = []
    for wire in system.wires_into(name):
        [value] = slaves[wire.source.instance].get([wire.source.variable])
        value = wire.conversion.of(value)
        before = sent.get(wire.target.name)
        if value != before:
            slaves[name].set([wire.target.variable], [value])
            sent[wire.target.name] = value
            if before is None or abs(value - before) > schedule.tolerance_of(wire):
                moved.append(wire)
    return moved
