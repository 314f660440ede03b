"""The flat program that `stepping` executes each tick, and the memory that it works on."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from master.system.channel import HELD

COPY, STEP, KEEP, EXTRAPOLATE, CHANNEL, SAVE, RESTORE, CHECK = range(8)

OPERATION_WIDTH, BLOCK_WIDTH, SLAVE_WIDTH, COPY_WIDTH = 6, 6, 7, 3  # cells of a row, see `Memory`

WARNING = 1  # the worst status of FMI with which a run goes on

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]


class Memory(NamedTuple):
    """
    Arrays of a program.

    `operations` has a row [code, every, a, b, c, d] for each operation:

        COPY         first row, behind the last            the `copies` in these rows
        STEP         slave                                 its inputs, one step of `every` ticks, its outputs
        KEEP         source, target, first cell, n cells   the value of n ticks ago, through a ring
        EXTRAPOLATE  target, order, first cell             to the end of the step, from the last values
        CHANNEL      target, row, first cell, n cells      a fault of the measuring chain, see `channels`
        SAVE         slave, get_state                      state of the slave -> states
        RESTORE      slave, set_state                      states -> state of the slave
        CHECK        loop                                  back to the loop's start until its wires agree

    `blocks`: [setter or getter, address of the references, n, n values, type, first place in values]
    `slaves`: [component, FMI version, do_step, first block to set, behind the last, first to get, behind]
    `copies`: [source, target, conversion]: values[target] = factor * values[source] + offset
    `conversions`: [factor, offset]
    `rings`: cells of KEEP, EXTRAPOLATE and CHANNEL
    `states`: address of each slave's saved state
    `loops`: [operation to go back to, first row of `residuals`, behind the last, most passes, passes]
    `residuals`: [source, target, conversion] of a wire that a loop must close, `tolerances` for each
    `channels`: [mode, offset, delay, jitter, fallback, random, its tick, drawn age, held] under a scenario
    """

    operations: Integers
    blocks: Integers
    slaves: Integers
    copies: Integers
    conversions: Floats
    values: Floats
    rings: Floats
    states: Integers
    loops: Integers
    residuals: Integers
    tolerances: Floats
    channels: Floats


@dataclass
class Program:
    """A program with the names that belong to its numbers."""

    memory: Memory
    place: dict[str, int]
    names: list[str]
    loop_wires: list[str]
    channel_of: dict[str, int]
    keep_alive: list[NDArray[np.uint32]] = field(default_factory=list)

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
            elif code == EXTRAPOLATE:
                self.rings[c : c + b] = self.values[a]
            elif code == CHANNEL:
                self.rings[c : c + d] = self.values[a]
                self.memory.channels[b, HELD] = self.values[a]

    def instance_of(self, operation: int) -> str:
        """Name the slave that an operation belongs to."""
        return self.names[int(self.operations[operation, 2])]
