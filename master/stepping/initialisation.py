"""Before the first tick: start values, initialisation mode, and initial values through the wires."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from master.coupling.schedule import Schedule
from master.errors import FmuError
from master.fmi.description import Variable
from master.fmi.slave import Slave
from master.stepping.machine.program import Program
from master.system.graph import Port, System, Wire


def initialise(
    system: System,
    schedule: Schedule,
    slaves: Mapping[str, Slave],
    t0: float,
    stop: float | None = None,
    given: Mapping[str, float] | None = None,
) -> None:
    """
    Enter initialisation, let the initial values run through the wires until they settle, and leave it.

    Each pass takes at least one wire of a path on, so that as many passes as wires settle any system
    without an algebraic loop. One within an iterated group is iterated to the group's tolerance.

    Args:
        system: The graph.
        schedule: The order in which inputs are set.
        slaves: Its FMUs, loaded or reset.
        t0: Start of the run [s].
        stop: Time that no step goes beyond [s], if it is known.
        given: Values of inputs that come from no wire, by `instance.variable`.

    Raises:
        FmuError: If an FMU refuses, or the values do not settle.
    """
    for name, slave in slaves.items():
        slave.enter_initialisation(system.instances[name].start, t0, stop)
    for signal, value in (given or {}).items():
        port = system.port(signal)
        slaves[port.instance].set([port.variable], [value])
    wires: dict[str, list[Wire]] = {}
    for wire in system.wires:
        wires.setdefault(wire.target.instance, []).append(wire)
    sent: dict[str, float] = {}
    for _ in range(len(system.wires) + 1 + schedule.initial_passes):
        moved = [
            wire for name in schedule.order for wire in _pull(schedule, slaves, wires.get(name, ()), sent)
        ]
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


def read_initial_values(
    system: System,
    slaves: Mapping[str, Slave],
    program: Program,
    read: Mapping[str, Sequence[Variable]] | None = None,
) -> None:
    """Row 0 of the table of values, and what older values are held at until their first ones arrive."""
    values, place = program.values, program.place
    for name, instance in system.instances.items():
        chosen = instance.description.outputs if read is None else read[name]
        for v, value in zip(chosen, slaves[name].get(chosen), strict=True):
            values[place[Port(name, v).name]] = value
    for wire in system.wires:
        source = values[place[wire.source.name]]
        values[place[wire.target.name]] = wire.conversion.factor * source + wire.conversion.offset
    program.fill_rings()


def _pull(
    schedule: Schedule, slaves: Mapping[str, Slave], wires: Sequence[Wire], sent: dict[str, float]
) -> list[Wire]:
    """Set the inputs of one slave to its sources' present values; give the wires whose value changed."""
    moved = []
    for wire in wires:
        [value] = slaves[wire.source.instance].get([wire.source.variable])
        value = wire.conversion.factor * value + wire.conversion.offset
        before = sent.get(wire.target.name)
        if value != before:
            slaves[wire.target.instance].set([wire.target.variable], [value])
            sent[wire.target.name] = value
            if before is None or abs(value - before) > schedule.tolerance_of(wire):
                moved.append(wire)
    return moved
