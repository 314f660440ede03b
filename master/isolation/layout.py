"""
The two memories of an isolated FMU, and what is where in them.

The **channel** is shared by the stepping process and the FMU's own. The FMU may write anything into it: what
is read from there is a value or a text, never an address, a length or an object. What the stepping process
relies on is in its **desk**, which it shares with nobody; the address of the desk is the `component` that the
stepping loop passes to the FMU's functions. The FMU's process has a desk of its own.

A request is made by writing the next number to REQUEST, and done when ANSWER has the same number. Inputs
that are set wait in the channel for the step that follows; after a step the outputs that have been asked for
before are there at once. So a step with inputs and outputs is one request.
"""

from __future__ import annotations

from enum import IntEnum

from master.fmi.value_types import INT_BOOLEAN

# Words of the channel, each on a line of the processor's cache of its own [bytes].
REQUEST = 0
REQUEST_SLEEPS = 64
ANSWER = 128
ANSWER_SLEEPS = 192

# Cells of 8 bytes of the channel, from its beginning.
OPERATION = 32
TICK = 33
TIME = 34  # start of a step [s]
LENGTH = 35  # of a step [s]
STATE = 36  # saved state that is meant, or that was made
N_SETS = 37
N_GETS = 38
WHICH = 39  # the entry among the outputs that is asked for
STATUS = 40
CALL = 41  # which call answered with it
FLAGS = 42  # four cells: answers to a step of FMI 3.0
HEADER_BYTES = 4096

# An entry of the inputs or outputs in the channel: cells, then references, then values.
ENTRY_TYPE, ENTRY_N, ENTRY_N_VALUES, ENTRY_VALUES_AT, ENTRY_NEXT, ENTRY_STATUS = range(6)
ENTRY_CELLS = 6

# Cells of a desk.
(
    CHANNEL,
    KERNEL,
    LOOKS,
    SEQUENCE,
    SCRATCH,  # two cells
    _SCRATCH_2,
    POSITION,
    SETS_AT,
    SETS_BYTES,
    GETS_AT,
    GETS_BYTES,
    # of the stepping process
    SETS_USED,
    GETS_USED,
    N_SET,
    N_PLANNED,
    IS_FRESH,
    N_STEPS,
    HOLDS,
    FAULT,
    WAIT_STATUS,
    PROCESS,
    DEADLINE,
    HELD,
    PLAN,
    FAULT_STATUS,
    FAULT_TICK,
    # of the FMU's process
    VERSION,
    COMPONENT,
    DO_STEP,
    GET_STATE,
    SET_STATE,
    FREE_STATE,
    IS_ASKED,
    PARENT,
    SETTERS,  # one cell a value type
) = range(35)
N_TYPES = INT_BOOLEAN + 1
GETTERS = SETTERS + N_TYPES
USAGE = GETTERS + N_TYPES  # what the kernel says that a process used
N_USAGE = 18
MOST_RESIDENT = USAGE + 4  # [kB]
N_DESK = USAGE + N_USAGE

# A row of the plan: an output that has been asked for.
PLAN_TYPE, PLAN_REFERENCES, PLAN_N, PLAN_N_VALUES, PLAN_ENTRY, PLAN_VALUES, PLAN_BYTES, PLAN_IS_HELD = range(
    8
)
PLAN_WIDTH = 8
MOST_PLANNED = 4096


class Request(IntEnum):
    """What the stepping process asks for."""

    STEP = 1
    APPLY = 2
    GET = 3
    SAVE = 4
    RESTORE = 5
    FREE = 6
    CALL = 7


class Fault(IntEnum):
    """How the process of an FMU failed."""

    NONE = 0
    ENDED = 1
    HUNG = 2
    REFUSED = 3


LOST = -32768
"""Status of a call whose process did not answer; FMI has none like it."""
