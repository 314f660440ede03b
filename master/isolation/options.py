"""How an FMU is isolated: what a user may ask for."""

from __future__ import annotations

import platform
import sys
from dataclasses import dataclass

STOP = "stop"
HOLD = "hold"
DEADLINE = 30.0  # s
MEGABYTE = 2**20

IS_POSSIBLE = sys.platform.startswith("linux") and platform.machine() in ("x86_64", "aarch64")
"""Whether FMUs can have processes of their own here."""


@dataclass(frozen=True)
class Isolation:
    """
    What an FMU in a process of its own may do.

    `deadline`: longest time of a call [s], of the loading at least DEADLINE; `memory`: what it may allocate
    [MB], half of the machine's if None; `on_fault`: whether its failure stops the run or its last values are
    held; `is_sandboxed`: whether it is kept from the network and from writing outside its folder.
    """

    deadline: float = DEADLINE
    memory: int | None = None
    on_fault: str = STOP
    is_sandboxed: bool = False
