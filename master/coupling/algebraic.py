"""
Algebraic loops: closed paths on which every FMU hands an input through to an output at once.

Whether it does stands in the FMU's ModelStructure; one that does not say counts as handing all inputs
to all outputs. Stepping cannot solve such a loop in one pass: the order decides which of its values is
old, or an iterated group solves it.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

from master.fmi.description import Description
from master.system.graph import System, Wire

from .ledger import steps_of
from .loops import closed_paths
from .schedule import Schedule

MOST_LOOPS = 100


@dataclass(frozen=True)
class AlgebraicLoop:
    """One loop: its signals, and the connections whose value is old in the chosen order, with the steps."""

    signals: tuple[str, ...]
    old: tuple[tuple[str, int], ...]

    @property
    def is_solved(self) -> bool:
        """Whether the loop is iterated, so that no value is old."""
        return not self.old

    def explain(self) -> str:
        """Say in one sentence what the loop is and what the order does to it."""
        path = " -> ".join((*self.signals, self.signals[0]))
        if self.is_solved:
            return f"{path}: iterated until it closes"
        parts = [f"{wire} is {steps} step{'s' * (steps > 1)} old" for wire, steps in self.old]
        return f"{path}: not solved within a step, {' and '.join(parts)}"


def algebraic_loops(system: System, schedule: Schedule) -> list[AlgebraicLoop]:
    """Find the algebraic loops of a scheduled system."""
    found = islice(closed_paths(system, Description.hands_through), MOST_LOOPS)
    return [_loop(schedule, [system.wires[i] for i in path]) for path in found]


def _loop(schedule: Schedule, wires: list[Wire]) -> AlgebraicLoop:
    signals = tuple(name for w in wires for name in (w.source.name, w.target.name))
    aged = [(w, steps_of(schedule, w)[1]) for w in wires]
    old = tuple((f"{w.source.name} -> {w.target.name}", steps) for w, steps in aged if steps)
    return AlgebraicLoop(signals, old)
