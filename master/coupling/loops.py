"""Closed paths over the connections of a system."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from ..fmi.description import Description
from ..system.graph import System, Wire

Passes = Callable[[Description, str, str], bool]


def closed_paths(system: System, passes: Passes) -> Iterator[tuple[int, ...]]:
    """
    Every closed path, each once, as places of its wires in `system.wires`.

    A path goes on from an input to those outputs of its FMU for which `passes(description, input,
    output)` holds. It may pass an FMU again by another output, as the force loop passes the compensator
    with the force and with the command, but no signal twice.
    """
    wires = system.wires
    follows = {
        i: [j for j, after in enumerate(wires) if _follows(system, wire, after, passes)]
        for i, wire in enumerate(wires)
    }
    for start in range(len(wires)):
        yield from _closed(wires, follows, start, (start,))


def _follows(system: System, wire: Wire, after: Wire, passes: Passes) -> bool:
    if wire.target.instance != after.source.instance:
        return False
    description = system.instances[wire.target.instance].description
    return passes(description, wire.target.variable.name, after.source.variable.name)


def _closed(
    wires: Sequence[Wire], follows: Mapping[int, Sequence[int]], start: int, path: tuple[int, ...]
) -> Iterator[tuple[int, ...]]:
    passed = {wires[i].source.name for i in path}
    for i in follows[path[-1]]:
        if i == start:
            yield path
        elif i > start and wires[i].source.name not in passed:
            yield from _closed(wires, follows, start, (*path, i))
