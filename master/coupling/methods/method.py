"""
What a coupling method is: how the members of one entry of `coupling.order` are stepped within a tick.

A method is one class in one file of this folder. It is written in YAML as its fields are (`members` as the
method's `key`), says what a system may not ask of it, emits the operations of a tick, gives the age of a
value between two members, and carries out the same tick on linear systems. Entries follow each other in the
order of the list, each with the newest values of those before it: that is the schedule's matter, not a
method's.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple, Protocol

from pydantic import Field

from master.text.fields import Finite, Integer, Section

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from master.system.graph import System, Wire

    Floats = NDArray[np.float64]

Members = Annotated[tuple[str, ...], Field(min_length=1)]
Tolerance = Annotated[Finite, Field(gt=0.0)]
Passes = Annotated[Integer, Field(ge=1, le=10**6)]


class Residual(NamedTuple):
    """Places of a source and of the input that took its value, and the wire between them."""

    source: int
    target: int
    wire: Wire


class Emitter(Protocol):
    """What a method may emit into the program of a tick; `every` is in ticks, see `machine/program.py`."""

    def wires_into(self, instance: str) -> Sequence[Wire]:
        """Connections of all inputs of an instance."""
        ...

    def transfer(self, wire: Wire, every: int) -> None:
        """Bring a connection's value to the input: its delay, conversion, fault and extrapolation."""
        ...

    def feed(self, instance: str, every: int) -> Mapping[str, int]:
        """Copy measured values to the inputs that have any; give these and their places."""
        ...

    def step(self, instance: str, every: int, back: int | None = None, length: int | None = None) -> None:
        """Step from `back` ticks before the end of the tick over `length` ticks; `every` if None."""
        ...

    def save(self, instance: str, every: int) -> None:
        """Save the state of an instance."""
        ...

    def restore(self, instance: str, every: int) -> None:
        """Put the saved state back."""
        ...

    def collect(self, source: int, first: int, n: int) -> None:
        """Write a value each tick to the next of n places, round and round."""
        ...

    def copy(self, source: int, target: int, every: int, wire: Wire | None = None) -> None:
        """Copy from place to place, converted as on a wire."""
        ...

    def here(self) -> int:
        """Place of the next operation."""
        ...

    def check(self, residuals: Sequence[Residual], maximum: int, back: int, every: int) -> None:
        """Go back to an operation until all residuals are within tolerance, at most `maximum` passes."""
        ...

    def source(self, wire: Wire) -> int:
        """Place of the output that a wire starts from."""
        ...

    def place(self, signal: str) -> int:
        """Place of a signal."""
        ...

    def arrived(self, wire: Wire) -> int:
        """Place of a wire's value before a fault of a scenario changes it: an iteration is judged by it."""
        ...

    def places(self, name: str, n: int) -> int:
        """Reserve n places in a row in the table of values and return the first."""
        ...


class LinearTick(Protocol):
    """
    What a method may do to the linear system within a tick.

    A signal is a row of coefficients over the total state at the start, outer signals, and unknowns.
    """

    signals: dict[str, Floats]
    collected: dict[str, list[Floats]]

    def wires_into(self, instance: str) -> Sequence[Wire]:
        """Connections of its inputs that vary continuously."""
        ...

    def delay_of(self, wire: Wire) -> int:
        """Whole ticks of delay of a connection."""
        ...

    def transfer(self, wire: Wire) -> None:
        """Bring a connection's value to the input."""
        ...

    def step(self, instances: Sequence[str]) -> None:
        """Step side by side with the signals as they are."""
        ...

    def step_implicitly(self, instances: Sequence[str], inner: Sequence[Wire]) -> None:
        """Step side by side, the inner wires with the new values: what an iteration converges to."""
        ...


class Method(Section, ABC):
    """
    One entry of `coupling.order`.

    `key`: the key of a mapping in YAML that names the method and lists its members; empty for one that is not
    written as a mapping. `ticks`: how many ticks pass between two updates of the members' outputs, times
    `every`.
    """

    key: ClassVar[str] = ""

    members: Members

    @property
    def ticks(self) -> int:
        """Number of ticks from one update of the members' outputs to the next, if `every` is 1."""
        return 1

    @property
    def initial_passes(self) -> int:
        """Passes over the wires that solve an algebraic loop of the members at the start."""
        return 0

    def faults(self, system: System, where: str) -> list[str]:
        """List what the system asks of its members that the method cannot do."""
        return []

    def event_faults(self, system: System, targets: Collection[str]) -> list[str]:
        """List the connected inputs under events, of those given, on which events cannot act."""
        return []

    def closes(self, wire: Wire) -> bool:
        """Whether a wire between two members is iterated until both of its ends agree."""
        return False

    def tolerance_of(self, wire: Wire) -> float:
        """How far the ends of a wire that it closes may be apart, in the target's unit."""
        return 0.0

    def age(self, wire: Wire) -> int:
        """Age in rows that it gives a value between two members, without the connection's delay."""
        return 0 if self.closes(wire) else 1

    @abstractmethod
    def emit(self, emitter: Emitter, every: Mapping[str, int]) -> None:
        """Emit the operations of a tick; `every`: ticks from one update of an instance to the next."""

    @abstractmethod
    def act(self, tick: LinearTick, k: int, every: Mapping[str, int]) -> None:
        """Carry out tick k on the linear system."""

    def __str__(self) -> str:
        return f"{self.key}: {', '.join(self.members)}"

    def written(self) -> Any:
        """Return the entry as it is written in YAML."""
        return self.model_dump(by_alias=True, mode="json")


def due(names: Sequence[str], k: int, every: Mapping[str, int]) -> list[str]:
    """Names of those that step in tick k: an instance at every n-th tick steps at the last of the n."""
    return [name for name in names if (k + 1) % every[name] == 0]
