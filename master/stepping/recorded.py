"""What a run records."""

from __future__ import annotations

from master.system.graph import Port, System


def recorded_ports(system: System) -> list[Port]:
    """List what a run records: all outputs, those of the whole system last."""
    own = [Port(n, v) for n, i in system.instances.items() for v in i.description.outputs]
    return own + [wire.target for wire in system.outlets]
