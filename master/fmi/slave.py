"""What the master needs of anything that steps: a slow side by name, a fast side of C functions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from .description import Description, Kind, Variable


@dataclass(frozen=True)
class CInterface:
    """
    Addresses that the stepping loop calls, in the form of FMI 2.0 or 3.0.

    `get_state`, `set_state` and `free_state` are 0 where the FMU cannot save its state.
    `setters` and `getters` map a kind of variable and its value type to a function address.
    """

    version: int
    component: int
    do_step: int
    setters: Mapping[tuple[Kind, int], int]
    getters: Mapping[tuple[Kind, int], int]
    get_state: int = 0
    set_state: int = 0
    free_state: int = 0


class Slave(Protocol):
    """One instance between its creation and its end."""

    name: str
    description: Description

    def interface(self) -> CInterface:
        """Addresses for the stepping loop."""
        ...

    def enter_initialisation(
        self, start: Mapping[str, float | str], t0: float, stop: float | None = None
    ) -> None:
        """Set start values and enter initialisation mode at t0 [s]; no step goes beyond `stop` [s]."""
        ...

    def exit_initialisation(self) -> None:
        """Leave initialisation mode; the slave may step now."""
        ...

    def reset(self) -> None:
        """Go back to the state after instantiation, whatever happened since."""
        ...

    def set(self, variables: Sequence[Variable], values: Sequence[float]) -> None:
        """Set variables."""
        ...

    def get(self, variables: Sequence[Variable]) -> list[float]:
        """Read variables."""
        ...

    def state_bytes(self) -> bytes:
        """Whole state as bytes, from which an instance in another process can go on."""
        ...

    def restore_bytes(self, data: bytes) -> None:
        """Go on from what `state_bytes` returned; the slave may step already."""
        ...

    def last_message(self) -> str:
        """What the slave said last through its logger, empty if nothing."""
        ...

    def asked_for_end(self) -> bool:
        """Whether the step that it discarded (FMI 2.0) is one at which it ends the simulation."""
        ...

    def process_fault(self) -> str:
        """How a process that the slave has of its own failed; empty if it goes on, or there is none."""
        ...

    def close(self, *, failed: bool, fatal: bool = False) -> None:
        """End the slave: not terminated if it failed, not called any more after a fatal status."""
        ...
