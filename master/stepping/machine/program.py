"""
The flat program that `execute` runs each tick, and the memory that it works on.

In tick k (from t0 + k h to t0 + (k + 1) h) the operations are executed from first to last. An operation is a
row [code, every, a, b, c, d]; it is skipped unless k + 1 is a multiple of `every`. `values` is the table of
values, one place for each signal; a connection with a unit conversion has factor and offset in `conversions`.

| code        | a      | b         | c          | d | what it does                                       |
|-------------|--------|-----------|------------|---|----------------------------------------------------|
| COPY        | first  | after     |            |   | for rows [source, target, conversion] of `copies`  |
|             |        |           |            |   | from `first` to before `after`, in order:          |
|             |        |           |            |   | values[target] = factor * values[source] + offset  |
| FEED        | first  | after     |            |   | for those rows [target, column] of `feeds`:        |
|             |        |           |            |   | values[target] = measured[k + 1, column]           |
| STEP        | slave  | back      | length     |   | sets the inputs of the slave from `values`; one    |
|             |        |           |            |   | step from t0 + (k + 1 - back) h over length * h;   |
|             |        |           |            |   | gets its outputs into `values`                     |
| KEEP        | source | target    | first cell | n | values[target] = what values[source] was n         |
|             |        |           |            |   | executions ago, in n cells of `rings`              |
| COLLECT     | source | first     | n          |   | values[first + k mod n] = values[source]           |
| EXTRAPOLATE | target | order     | first cell |   | values[target] = polynomial through it and what it |
|             |        |           |            |   | was in the last `order` executions, one further    |
| CHANNEL     | target | row       | first cell | n | values[target] passes the fault in that row of     |
|             |        |           |            |   | `channels`, its past in n cells of `rings`         |
| MAP         | source | target    | first      | n | values[target] = second of that of n rows of       |
|             |        |           |            |   | `maps` whose first is values[source], else itself  |
| SAVE        | slave  | get_state |            |   | states[slave] = state of the slave                 |
| RESTORE     | slave  | set_state |            |   | state of the slave = states[slave]                 |
| CHECK       | loop   |           |            |   | goes on if each residual of that row of `loops` is |
|             |        |           |            |   | within its tolerance, else back to its operation;  |
|             |        |           |            |   | ends the execution after its most passes           |

The steps of an FMU that answer with anything but OK or WARNING end the execution, as do getters, setters,
SAVE and RESTORE; so does an integer input that its type does not hold.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from master.system.channel import HELD

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


class Operation(IntEnum):
    """Codes of operations; the first three make up a plain program, see `is_plain`."""

    COPY = 0
    FEED = 1
    STEP = 2
    KEEP = 3
    COLLECT = 4
    EXTRAPOLATE = 5
    CHANNEL = 6
    MAP = 7
    SAVE = 8
    RESTORE = 9
    CHECK = 10


# The same as integers, for compiled code: enumerations there cost seconds of compilation.
COPY, FEED, STEP, KEEP, COLLECT, EXTRAPOLATE, CHANNEL, MAP, SAVE, RESTORE, CHECK = map(int, Operation)

# Cells of a row, see `Memory`.
OPERATION_WIDTH = 6
BLOCK_WIDTH = 6
SLAVE_WIDTH = 8
COPY_WIDTH = 3
FEED_WIDTH = 2
CONVERSION_WIDTH = 2
MAP_WIDTH = 2
LOOP_WIDTH = 5
RESIDUAL_WIDTH = 3

ANSWER_CELLS = 4  # of 8 bytes: what an FMU 3.0 answers to a step


class Memory(NamedTuple):
    """
    Arrays of a program.

    `operations`: [code, every, a, b, c, d], see the table of this module
    `blocks`: [setter or getter, address of the references, n, n values, type, first place in values]
    `slaves`: [component, FMI version, do_step, first block to set, after the last, first to get, after,
              may change the floating-point mode]
    `copies`: [source, target, conversion]
    `conversions`: [factor, offset]
    `maps`: [value, what MAP puts in its place]
    `feeds`: [target, column]
    `measured`: values that FEED copies, a row for each tick and one before the first
    `values`: one place for each signal
    `scratch`: `ANSWER_CELLS`, followed by room for the largest block
    `rings`: cells of KEEP, EXTRAPOLATE and CHANNEL
    `states`: address of each slave's saved state
    `loops`: [operation to go back to, first row of `residuals`, after the last, most passes, passes]
    `residuals`: [source, target, conversion]: |factor * source + offset - target|, at most `tolerances`
    `channels`: a row of columns as in `master.system.channel.Channel` for each connection under a scenario
    `position`: cells that say which tick, slave and function is going on, see `process.position`
    """

    operations: Integers
    blocks: Integers
    slaves: Integers
    copies: Integers
    conversions: Floats
    maps: Floats
    feeds: Integers
    measured: Floats
    values: Floats
    scratch: Floats
    rings: Floats
    states: Integers
    loops: Integers
    residuals: Integers
    tolerances: Floats
    channels: Floats
    position: Floats


class BlockRow(NamedTuple):
    """A row of `blocks`: one call of a setter or getter."""

    function: int
    references: int
    n: int
    n_values: int
    value_type: int
    place: int


@dataclass
class Program:
    """A program with the names that belong to its numbers; `slaves` are instances and FMI versions."""

    memory: Memory
    place: dict[str, int]
    slaves: list[tuple[str, int]]
    loop_wires: list[str]
    channel_of: dict[str, int]
    keep_alive: list[NDArray[np.uint32]] = field(default_factory=list)

    @property
    def names(self) -> list[str]:
        """Instances, by their numbers."""
        return [name for name, _ in self.slaves]

    @property
    def operations(self) -> Integers:
        """Operations of one tick."""
        return self.memory.operations

    @property
    def values(self) -> Floats:
        """Table of values."""
        return self.memory.values

    @property
    def rings(self) -> Floats:
        """Cells that hold older values."""
        return self.memory.rings

    def fill_rings(self) -> None:
        """Let all that holds older values hold the present ones."""
        for code, _, a, b, c, d in self.operations:
            if code == KEEP:
                self.rings[c : c + d] = self.values[a]
            elif code == COLLECT:
                self.values[b : b + c] = self.values[a]
            elif code == EXTRAPOLATE:
                self.rings[c : c + b] = self.values[a]
            elif code == CHANNEL:
                self.rings[c : c + d] = self.values[a]
                self.memory.channels[b, HELD] = self.values[a]

    def feed(self, measured: Floats) -> None:
        """Let FEED copy from other values, shape (ticks + 1, columns)."""
        self.memory = self.memory._replace(measured=np.ascontiguousarray(measured))

    def instance_of(self, operation: int) -> str:
        """Name the slave that an operation belongs to."""
        return self.slaves[int(self.operations[operation, 2])][0]

    def blocks_to_set(self, operation: int) -> list[BlockRow]:
        """Setters that a STEP calls."""
        first, after = self.memory.slaves[self.operations[operation, 2], 3:5]
        return [BlockRow(*row) for row in self.memory.blocks[first:after].tolist()]

    def signal_at(self, place: int) -> str:
        """Name the signal at a place of the table of values."""
        return next(name for name, at in self.place.items() if at == place)
