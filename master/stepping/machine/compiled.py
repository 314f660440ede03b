"""The stepping loop as machine code, kept on disk between processes."""

from __future__ import annotations

import ctypes
import struct
import threading
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np

from master.fmi.native.cells import integer_at, load, pointer_to, store
from master.fmi.native.jit import is_switched_off
from master.fmi.native.kept_code import compile_code, digest_of, kept_file, load_code
from master.fmi.value_types import FLOAT64, INT64
from master.installation import cache_folder

from .interpreter import Execution, LimitMonitor, execute, is_plain
from .program import Floats, Integers, Memory

PACKAGE = Path(__file__).parents[2]
SOURCES = (
    "stepping/machine/compiled",
    "stepping/machine/interpreter",
    "stepping/machine/fmu_step",
    "stepping/machine/operations",
    "stepping/machine/pace",
    "stepping/machine/program",
    "system/channel",
    "coupling/extrapolation",
    "fmi/native/calls",
    "fmi/native/cells",
    "fmi/native/float_mode",
    "fmi/native/jit",
    "fmi/value_types",
    "process/position",
)
"""All files whose code is compiled; a test compares them with what they import."""

Execute = Callable[..., Execution]


# Cells of 8 bytes of a frame, through which a call passes its arguments and its result. Tables come first,
# with address, rows and columns each.
N_TABLES = len(Memory._fields) + len(LimitMonitor._fields)
ROWS = 3 * N_TABLES
T0 = ROWS + 3
H = T0 + 1
BEGIN = H + 1
END = BEGIN + 1
PACE = END + 1
RESULT = PACE + 1
N_CELLS = RESULT + len(Execution._fields)
_ARGUMENTS = struct.Struct("3q2d3q")  # from ROWS to PACE
_RESULT = struct.Struct("5q")


@lru_cache(maxsize=1)
def digest_of_sources() -> str:
    """Digest of all files whose code is compiled."""
    return digest_of([PACKAGE / f"{name}.py" for name in SOURCES])


@lru_cache(maxsize=1)
def compiled() -> Execute:
    """Return `execute` as compiled code: it takes the same arguments but `general`, `pace` by its name."""
    return execute if is_switched_off() else _executed


def load_plain() -> None:
    """Load the code for plain programs, so that processes forked from this one have it."""
    if not is_switched_off():
        _function(is_plain=True, is_paced=False)


def _executed(
    memory: Memory,
    monitor: LimitMonitor,
    t0: float,
    h: float,
    begin: int,
    end: int,
    rows: Floats,
    *,
    pace: int | None = None,
) -> Execution:
    if _last.memory is not memory or _last.monitor is not monitor:
        _last.prepare(memory, monitor)
    _ARGUMENTS.pack_into(_last.frame, 8 * ROWS, rows.ctypes.data, *rows.shape, t0, h, begin, end, pace or 0)
    _function(is_plain=_last.is_plain, is_paced=pace is not None)(_last.address)
    return Execution(*_RESULT.unpack_from(_last.frame, 8 * RESULT))


class _Last(threading.local):
    """The frame of what a thread executed last: of a program that goes on tick by tick it is made once."""

    memory: Memory | None = None
    monitor: LimitMonitor | None = None

    def prepare(self, memory: Memory, monitor: LimitMonitor) -> None:
        """Make a frame with the tables of a program."""
        cells = np.zeros(N_CELLS, dtype=np.int64)
        for i, table in enumerate((*memory, *monitor)):
            cells[3 * i : 3 * i + table.ndim + 1] = table.ctypes.data, *table.shape
        self.frame = cells.data
        self.address = cells.ctypes.data
        self.is_plain = is_plain(memory)
        self.memory = memory
        self.monitor = monitor


_last = _Last()


@lru_cache(maxsize=4)
def _function(*, is_plain: bool, is_paced: bool) -> Callable[[int], int]:
    name = f"loop{'-plain' if is_plain else ''}{'-paced' if is_paced else ''}"
    file = kept_file(cache_folder(), name, digest_of_sources())
    code = load_code(file)
    if code is None:
        code = compile_code(file, "int64(int64)", _on_a_frame(is_plain=is_plain, is_paced=is_paced))
    function = ctypes.PYFUNCTYPE(ctypes.c_int64, ctypes.c_int64)(code.address)
    function.code = code  # type: ignore[attr-defined]  # which lives as long
    return function


def _on_a_frame(*, is_plain: bool, is_paced: bool) -> Callable[[int], int]:
    """Return `execute` as a function of the address of a frame."""
    from numba import carray  # type: ignore[attr-defined]
    from numba.extending import register_jitable

    general = None if is_plain else True

    @register_jitable
    def integers(frame: int, i: int) -> Integers:
        return carray(pointer_to(integer_at(frame, 3 * i)), (integer_at(frame, 3 * i + 1),), np.int64)

    @register_jitable
    def floats(frame: int, i: int) -> Floats:
        return carray(pointer_to(integer_at(frame, 3 * i)), (integer_at(frame, 3 * i + 1),), np.float64)

    @register_jitable
    def rows_of_integers(frame: int, i: int) -> Integers:
        shape = (integer_at(frame, 3 * i + 1), integer_at(frame, 3 * i + 2))
        return carray(pointer_to(integer_at(frame, 3 * i)), shape, np.int64)

    @register_jitable
    def rows_of_floats(frame: int, i: int) -> Floats:
        shape = (integer_at(frame, 3 * i + 1), integer_at(frame, 3 * i + 2))
        return carray(pointer_to(integer_at(frame, 3 * i)), shape, np.float64)

    @register_jitable
    def executed(frame: int, pace: int | None) -> int:
        memory = Memory(
            rows_of_integers(frame, 0),  # operations
            rows_of_integers(frame, 1),  # blocks
            rows_of_integers(frame, 2),  # slaves
            rows_of_integers(frame, 3),  # copies
            rows_of_floats(frame, 4),  # conversions
            rows_of_floats(frame, 5),  # maps
            rows_of_integers(frame, 6),  # feeds
            rows_of_floats(frame, 7),  # measured
            floats(frame, 8),  # values
            floats(frame, 9),  # scratch
            floats(frame, 10),  # rings
            integers(frame, 11),  # states
            rows_of_integers(frame, 12),  # loops
            rows_of_integers(frame, 13),  # residuals
            floats(frame, 14),  # tolerances
            rows_of_floats(frame, 15),  # channels
            floats(frame, 16),  # position
        )
        monitor = LimitMonitor(
            integers(frame, 17),  # record
            floats(frame, 18),  # limits
            integers(frame, 19),  # used
            integers(frame, 20),  # first_beyond
            rows_of_integers(frame, 21),  # triggers
            rows_of_floats(frame, 22),  # thresholds
        )
        t0, h = load(frame, T0, FLOAT64), load(frame, H, FLOAT64)
        begin, end = integer_at(frame, BEGIN), integer_at(frame, END)
        ended = execute(memory, monitor, t0, h, begin, end, rows_of_floats(frame, N_TABLES), general, pace)
        store(frame, RESULT, INT64, float(ended.stop))
        store(frame, RESULT + 1, INT64, float(ended.ticks))
        store(frame, RESULT + 2, INT64, float(ended.where))
        store(frame, RESULT + 3, INT64, float(ended.status))
        store(frame, RESULT + 4, INT64, float(ended.call))
        return 0

    def paced(frame: int) -> int:
        return executed(frame, integer_at(frame, PACE))

    def unpaced(frame: int) -> int:
        return executed(frame, None)

    return paced if is_paced else unpaced
