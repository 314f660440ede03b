"""
Waveform relaxation: the members run through a window of ticks, again and again, until their waveforms agree.

In YAML `{waveform: [a, b], window: 4, sweep: gauss_seidel, tolerance: 1e-6, maximum: 20}`. The group is
worked off at the last tick of each window: every member goes back to its state at the begin of the window and
makes its `window` steps in one go, with the others' values of the same ticks from the sweep before (`jacobi`)
or, where they came before it in this sweep, from this one (`gauss_seidel`). The first sweep takes the values
from before the window. Converged, each tick of the window is solved implicitly, as `iterate` does tick by
tick.

Causality   Values from outside the group are collected tick by tick, and each step of the window takes those
            of its own tick: they are as old as they would be without a window. The members' own values reach
            the results and the FMUs outside at the end of the window only, and are held until the next: like
            those of an FMU with `every: window`. So no row holds a value of a later time, and none is filled
            in later.
Age         0 between members, at the rows at which a window ends. A delayed connection between two members is
            one from outside: it sends what the rows hold.
Limits      Ticks after the last whole window are not stepped. Members step every tick: they have `every: 1`.
Source      E. Lelarasmee, A. E. Ruehli, A. L. Sangiovanni-Vincentelli, IEEE Trans. CAD 1 (1982) 131-145.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import Field

from master.text.fields import Integer

from .iterated import Iterated
from .method import Emitter, LinearTick, Members, Passes, Residual, Tolerance

if TYPE_CHECKING:
    from master.system.graph import System, Wire

    from .method import Floats

LONGEST_WINDOW = 10_000  # ticks; each has operations of its own in the program


class Waveform(Iterated):
    """Members that run through a window until their waveforms agree."""

    key: ClassVar[str] = "waveform"

    members: Members = Field(alias="waveform")
    window: Annotated[Integer, Field(ge=1, le=LONGEST_WINDOW)]
    sweep: Literal["gauss_seidel", "jacobi"] = "gauss_seidel"
    tolerance: Tolerance = 1e-9
    maximum: Passes = 50

    @property
    def ticks(self) -> int:
        return self.window

    def faults(self, system: System, where: str) -> list[str]:
        found = super().faults(system, where)
        for name in self.members:
            every = system.instances[name].every if name in system.instances else 1
            if every != 1:
                found.append(
                    f"{where}: {name} is in a waveform group, got every {every} ticks, expected every: 1 "
                    "(it makes a step for each tick of the window)"
                )
        return found

    def event_faults(self, system: System, targets: Collection[str]) -> list[str]:
        inner = [w.target.name for n in self.members for w in system.wires_into(n) if self.closes(w)]
        return [
            f"{name} is closed over a window of {self.window} ticks by a waveform group, got a fault on it, "
            "expected it elsewhere"
            for name in inner
            if name in targets
        ]

    def emit(self, emitter: Emitter, every: Mapping[str, int]) -> None:
        window = self.window
        wires = [w for name in self.members for w in emitter.wires_into(name)]
        inner = [w for w in wires if self.closes(w)]
        leaving = {w.source.name: w for w in inner}
        taken = self._collected(emitter, [w for w in wires if not self.closes(w)])
        taken |= {w.target.name: emitter.places(f"{w.target.name} in the window", window) for w in inner}
        sent = {name: emitter.places(f"{name} in the window", window) for name in leaving}
        for name in self.members:
            emitter.save(name, window)
        for source, wire in leaving.items():
            for j in range(window):
                emitter.copy(emitter.source(wire), sent[source] + j, window)
        back = emitter.here()
        for name in self.members:
            emitter.restore(name, window)
        if self.sweep == "jacobi":
            self._take(emitter, inner, sent, taken)
        for name in self.members:
            if self.sweep == "gauss_seidel":
                self._take(emitter, [w for w in inner if w.target.instance == name], sent, taken)
            arriving = {n: place for n, place in taken.items() if n.partition(".")[0] == name}
            for j in range(window):
                for target, place in arriving.items():
                    emitter.copy(place + j, emitter.place(target), window)
                emitter.step(name, window, back=window - j, length=1)
                for source, wire in leaving.items():
                    if wire.source.instance == name:
                        emitter.copy(emitter.source(wire), sent[source] + j, window)
        residuals = [
            Residual(sent[w.source.name] + j, taken[w.target.name] + j, w)
            for w in inner
            for j in range(window)
        ]
        emitter.check(residuals, self.maximum, back, window)

    def _collected(self, emitter: Emitter, outer: Sequence[Wire]) -> dict[str, int]:
        """Collect what arrives from outside tick by tick; give the first of its places for each input."""
        arriving: dict[str, int] = {}
        for name in self.members:
            arriving |= emitter.feed(name, 1)
        for wire in outer:
            emitter.transfer(wire, 1)
            arriving[wire.target.name] = emitter.place(wire.target.name)
        first = {name: emitter.places(f"{name} in the window", self.window) for name in arriving}
        for name, place in arriving.items():
            emitter.collect(place, first[name], self.window)
        return first

    def _take(
        self, emitter: Emitter, wires: Sequence[Wire], sent: Mapping[str, int], taken: Mapping[str, int]
    ) -> None:
        """Let wires carry the whole waveforms of their sources."""
        for wire in wires:
            for j in range(self.window):
                emitter.copy(sent[wire.source.name] + j, taken[wire.target.name] + j, self.window, wire)

    def act(self, tick: LinearTick, k: int, every: Mapping[str, int]) -> None:
        inner = self._transfer_outer(tick, True)
        closed = {w.target.name for w in inner}
        outer = [
            w.target.name for n in self.members for w in tick.wires_into(n) if w.target.name not in closed
        ]
        for name in outer:
            tick.collected.setdefault(name, []).append(tick.signals[name])
        if (k + 1) % self.window:
            return
        waveforms: dict[str, list[Floats]] = {name: tick.collected.pop(name) for name in outer}
        for j in range(self.window):
            for name, rows in waveforms.items():
                tick.signals[name] = rows[j]
            tick.step_implicitly(self.members, inner)
