"""Before the first tick: start values, initialisation mode, and initial values through the wires."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

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
    last: Collection[str] = (),
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
        last: Instances that leave initialisation after the others, with what these then give: not every FMU
            computes its outputs before.

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
    for name, slave in slaves.items():
        if name not in last:
            slave.exit_initialisation()
    for name in schedule.order:
        if name in last:
            _pull(schedule, slaves, wires.get(name, ()), sent)
            slaves[name].exit_initialisation()


def read_initial_values(
    system: System,
    slaves: Mapping[str, Slave],
    program: Program,
    read: Mapping[str, Sequence[Variable]] | None = None,
) -> None:
    """Row 0 of the table of values, and what older values are held at until their first ones arrive."""
    values, place = program.values, program.place
    for name in system.instances:
        chosen = system.read_from(name) if read is None else read[name]
        for v, value in zip(chosen, slaves[name].get(chosen), strict=True):
            values[place[Port(name, v).name]] = value
    wired = {wire.target.name for wire in system.wires}
    for name, instance in system.instances.items():  # of an array in part, the rest stays as the FMU has it
        signals = [(v, Port(name, v).name) for v in instance.description.inputs_in_arrays]
        kept = [v for v, signal in signals if signal in place and signal not in wired]
        for v, value in zip(kept, slaves[name].get(kept) if kept else (), strict=True):
            values[place[Port(name, v).name]] = value
    for wire in system.wires:
        source = values[place[wire.source.name]]
        values[place[wire.target.name]] = wire.conversion.of(source)
    for wire in system.outlets if read is None else ():
        name = wire.target.name
        values[place[name]] = (
            system.held[name] if name in system.held else wire.conversion.of(values[place[wire.source.name]])
        )
    program.fill_rings()


def _pull(
    schedule: Schedule, slaves: Mapping[str, Slave], wires: Sequence[Wire], sent: dict[str, float]
) -> list[Wire]:
    """Set the inputs of one slave to its sources' present values; give the wires whose value changed."""
    others = [w for w in wires if w.source.instance != w.target.instance]
    # what an FMU sends itself may change with each input; what others send does not
    own = [[w] for w in wires if w.source.instance == w.target.instance]
    return [moved for part in (others, *own) for moved in _send(schedule, slaves, part, sent)]


def _send(
    schedule: Schedule, slaves: Mapping[str, Slave], wires: Sequence[Wire], sent: dict[str, float]
) -> list[Wire]:
    """Set the inputs of one slave at the end of some wires; return the wires whose value changed."""
    moved: list[Wire] = []
    targets: list[Variable] = []
    values: list[float] = []
    for wire, taken in zip(wires, _read(slaves, wires), strict=True):
        value = wire.conversion.of(taken)
        before = sent.get(wire.target.name)
        if value != before:
            targets.append(wire.target.variable)
            values.append(value)
            sent[wire.target.name] = value
            if before is None or abs(value - before) > schedule.tolerance_of(wire):
                moved.append(wire)
    if targets:
        slaves[wires[0].target.instance].set(targets, values)
    return moved


def _read(slaves: Mapping[str, Slave], wires: Sequence[Wire]) -> list[float]:
    """Present values at the sources of wires, read from each slave at once."""
    sources: dict[str, list[int]] = {}
    for i, wire in enumerate(wires):
        sources.setdefault(wire.source.instance, []).append(i)
    found = [0.0] * len(wires)
    for instance, places in sources.items():
        got = slaves[instance].get([wires[i].source.variable for i in places])
        for i, value in zip(places, got, strict=True):
            found[i] = value
    return found
