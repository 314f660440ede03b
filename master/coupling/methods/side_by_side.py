"""
Side by side (Jacobi): all members step on the values from before the group.

In YAML a list within the list, `order: [[a, b], c]`; a name alone is a group of one, so that a plain list is
a sequence (Gauss-Seidel). A value between two members is one row old.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .method import Emitter, LinearTick, Method, due


class SideBySide(Method):
    """Members that step together."""

    def emit(self, emitter: Emitter, every: Mapping[str, int]) -> None:
        for name in self.members:
            emitter.feed(name, every[name])
            for wire in emitter.wires_into(name):
                emitter.transfer(wire, every[name])
        for name in self.members:
            emitter.step(name, every[name])

    def act(self, tick: LinearTick, k: int, every: Mapping[str, int]) -> None:
        stepping = due(self.members, k, every)
        for name in self.members:
            for wire in tick.wires_into(name):
                if name in stepping or tick.delay_of(wire):
                    tick.transfer(wire)
        tick.step(stepping)

    def __str__(self) -> str:
        return " | ".join(self.members)

    def written(self) -> Any:
        return self.members[0] if len(self.members) == 1 else list(self.members)
