"""Calls that save the state of an FMU, put it back and free it, outside the stepping loop."""

from __future__ import annotations

from enum import StrEnum

from master.process import position

from .native import calls
from .native.float_mode import restore_float_mode
from .slave import Slave


class StateCall(StrEnum):
    """Functions of an FMU for its state, by their verbs."""

    SAVE = "Get"
    RESTORE = "Set"
    FREE = "Free"


def call_state(slave: Slave, call: StateCall, argument: int) -> int:
    """
    Call one of the functions and return its status.

    Args:
        slave: Whose state it is.
        call: Which function.
        argument: The state; for SAVE and FREE the address of the place that holds it.
    """
    interface = slave.interface()
    functions = {
        StateCall.SAVE: interface.get_state,
        StateCall.RESTORE: interface.set_state,
        StateCall.FREE: interface.free_state,
    }
    noun = "FMUstate" if interface.version == 2 else "FMUState"
    position.current().enter(slave.name, f"fmi{interface.version}{call}{noun}")
    status = calls.state(functions[call], interface.component, argument)
    position.current().leave()
    restore_float_mode()
    return status
