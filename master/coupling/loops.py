"""Closed paths over the connections of a system."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache

from master.fmi.description import Description
from master.system.graph import System, Wire

Follows = Callable[[int], Sequence[int]]
Passes = Callable[[Description, str, str], bool]


def closed_paths(system: System, passes: Passes) -> Iterator[tuple[int, ...]]:
    """
    Every closed path, each once, as places of its wires in `system.wires`.

    A path goes on from an input to those outputs of its FMU for which `passes(description, input,
    output)` holds. It may pass an FMU again by another output, as the force loop passes the compensator
    with the force and with the command, but no signal twice. No step is taken that does not lead back,
    so that the next path comes soon however many there are.
    """
    wires = system.wires
    leaving: dict[str, list[int]] = {}
    for i, wire in enumerate(wires):
        leaving.setdefault(wire.source.instance, []).append(i)

    @cache  # many paths are never looked at: the caller may have seen enough after some
    def follows(i: int) -> list[int]:
        wire = wires[i]
        return [j for j in leaving.get(wire.target.instance, ()) if _follows(system, wire, wires[j], passes)]

    for start in range(len(wires)):
        yield from _closed(wires, follows, start)


def _follows(system: System, wire: Wire, after: Wire, passes: Passes) -> bool:
    description = system.instances[wire.target.instance].description
    return passes(description, wire.target.variable.name, after.source.variable.name)


def _closed(wires: Sequence[Wire], follows: Follows, start: int) -> Iterator[tuple[int, ...]]:
    """Closed paths from a wire over those that stand behind it."""
    path, passed, ways = [start], {wires[start].source.name}, [iter(follows(start))]
    while ways:
        i = next(ways[-1], None)
        if i is None:
            ways.pop()
            passed.discard(wires[path.pop()].source.name)
        elif i == start:
            yield tuple(path)
        elif (
            i > start and wires[i].source.name not in passed and _leads_back(wires, follows, start, i, passed)
        ):
            path.append(i)
            passed.add(wires[i].source.name)
            ways.append(iter(follows(i)))


def _leads_back(wires: Sequence[Wire], follows: Follows, start: int, first: int, passed: set[str]) -> bool:
    """Whether the start can be reached over signals that have not been passed."""
    seen, waiting = {first}, [first]
    while waiting:
        for i in follows(waiting.pop()):
            if i == start:
                return True
            if i > start and i not in seen and wires[i].source.name not in passed:
                seen.add(i)
                waiting.append(i)
    return False
