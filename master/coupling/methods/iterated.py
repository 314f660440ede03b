"""
Iteration: the members step one after the other, again and again from saved states, until their wires agree.

In YAML `{iterate: [a, b], tolerance: 1e-9, maximum: 50}`. The tolerance is relative to the nominal value of
each input; that of a connection replaces it. A value between two members is of the same row; a delayed
connection is not iterated. The passes are those of Gauss-Seidel; converged, the members have solved the tick
implicitly.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from master.coupling import extrapolation

from .method import Emitter, LinearTick, Members, Method, Passes, Residual, Tolerance, due

if TYPE_CHECKING:
    from master.system.graph import System, Wire


class Iterated(Method):
    """Members that step until their wires agree."""

    key: ClassVar[str] = "iterate"

    members: Members = Field(alias="iterate")
    tolerance: Tolerance = 1e-9
    maximum: Passes = 50

    @property
    def initial_passes(self) -> int:
        return self.maximum

    def faults(self, system: System, where: str) -> list[str]:
        members = [system.instances[name] for name in self.members if name in system.instances]
        found = [
            f"{where}: {i.name} cannot be iterated, got an FMU that does not save its state"
            for i in members
            if not i.description.can_get_and_set_state
        ]
        inner = [
            f"{w.source.name} -> {w.target.name}" for w in system.wires if w.extrapolation and self.closes(w)
        ]
        found += extrapolation.faults(inner, where)
        found += [
            f"{where}: an iterated connection has no map, got {w.source.name} -> {w.target.name}"
            for w in system.wires
            if not w.conversion.is_affine and self.closes(w)
        ]
        rates = {i.every for i in members}
        if len(rates) > 1:
            found.append(f"{where}: an iterated group has one rate, got every {sorted(rates)} ticks")
        return found

    def closes(self, wire: Wire) -> bool:
        inside = wire.source.instance in self.members and wire.target.instance in self.members
        return inside and not wire.delay

    def tolerance_of(self, wire: Wire) -> float:
        tolerance = self.tolerance if wire.tolerance is None else wire.tolerance
        return tolerance * (wire.target.variable.nominal or 1.0)

    def emit(self, emitter: Emitter, every: Mapping[str, int]) -> None:
        rate = every[self.members[0]]
        inner: list[Wire] = []
        for name in self.members:
            emitter.feed(name, rate)
            for wire in emitter.wires_into(name):
                if self.closes(wire):
                    inner.append(wire)
                else:
                    emitter.transfer(wire, rate)
        for name in self.members:
            emitter.save(name, rate)
        back = emitter.here()
        for name in self.members:
            emitter.restore(name, rate)
        for name in self.members:
            for wire in inner:
                if wire.target.instance == name:
                    emitter.transfer(wire, rate)
            emitter.step(name, rate)
        residuals = [Residual(emitter.source(w), emitter.arrived(w), w) for w in inner]
        emitter.check(residuals, self.maximum, back, rate)

    def act(self, tick: LinearTick, k: int, every: Mapping[str, int]) -> None:
        stepping = due(self.members, k, every)
        inner = self._transfer_outer(tick, bool(stepping))
        if stepping:
            tick.step_implicitly(stepping, inner)

    def _transfer_outer(self, tick: LinearTick, is_due: bool) -> Sequence[Wire]:
        inner: list[Wire] = []
        for name in self.members:
            for wire in tick.wires_into(name):
                if self.closes(wire) and not tick.delay_of(wire):
                    inner.append(wire)
                elif is_due or tick.delay_of(wire):
                    tick.transfer(wire)
        return inner
