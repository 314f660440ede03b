"""
Values of every FMI type in memory, at an address, and the way between them and doubles.

As in `calls`, each access has a Python form over ctypes and one for compiled code, which chooses among typed
loads and stores: views of arrays would take seconds to compile.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from llvmlite import ir

from master.fmi.value_types import (
    BOOLEAN,
    FLOAT32,
    FLOAT64,
    INT8,
    INT16,
    INT32,
    INT64,
    INT_BOOLEAN,
    RANGES,
    UINT8,
    UINT16,
    UINT32,
    UINT64,
)

from .jit import emitted, inner

LARGEST_SIZE = 8

_FLOATS = {FLOAT64: ctypes.c_double, FLOAT32: ctypes.c_float}
_SIGNED = {INT8: ctypes.c_int8, INT16: ctypes.c_int16, INT32: ctypes.c_int32, INT64: ctypes.c_int64}
_UNSIGNED = {UINT8: ctypes.c_uint8, UINT16: ctypes.c_uint16, UINT32: ctypes.c_uint32, UINT64: ctypes.c_uint64}
_TRUTHS = {BOOLEAN: ctypes.c_uint8, INT_BOOLEAN: ctypes.c_int32}
_CELLS: dict[int, Any] = {**_FLOATS, **_SIGNED, **_UNSIGNED, **_TRUTHS}


_LEAST = np.array([RANGES.get(kind, (-math.inf, math.inf))[0] for kind in range(INT_BOOLEAN + 1)])
_LARGEST = np.array([RANGES.get(kind, (-math.inf, math.inf))[1] for kind in range(INT_BOOLEAN + 1)])


def size_of(kind: int) -> int:
    """Bytes of a value of a type."""
    return ctypes.sizeof(_CELLS[kind])


@inner
def first_misfit(doubles: int, n: int, kind: int) -> int:
    """Count to the first of n doubles at an address that a whole type cannot hold; -1 if there is none."""
    if _LARGEST[kind] < np.inf:
        for j in range(n):
            if not (_LEAST[kind] <= np.rint(load(doubles, j, FLOAT64)) <= _LARGEST[kind]):
                return j
    return -1


@inner
def pack(doubles: int, n: int, kind: int, typed: int) -> bool:
    """Write n doubles at an address as values of a type at another one; False if it does not hold them."""
    if first_misfit(doubles, n, kind) >= 0:
        return False
    for j in range(n):
        store(typed, j, kind, load(doubles, j, FLOAT64))
    return True


@inner
def unpack(doubles: int, n: int, kind: int, typed: int) -> None:
    """Read n values of a type at an address into doubles at another address."""
    for j in range(n):
        store(doubles, j, FLOAT64, load(typed, j, kind))


def load(address: int, j: int, kind: int) -> float:
    """Read the j-th value of a type from an address on."""
    cell = _CELLS[kind]
    return float(cell.from_address(int(address) + j * ctypes.sizeof(cell)).value)


def store(address: int, j: int, kind: int, value: float) -> None:
    """Write the j-th value of a type from an address on: whole numbers to the nearest, true if not zero."""
    cell = _CELLS[kind]
    typed = value if kind in _FLOATS else value != 0.0 if kind in _TRUTHS else int(np.rint(value))
    cell.from_address(int(address) + j * ctypes.sizeof(cell)).value = typed


@inner
def row_at(table: int, width: int, i: int) -> int:
    """Address of the i-th row of a table, `width` cells of 8 bytes wide."""
    return table + 8 * width * i


def integer_at(address: int, j: int) -> int:
    """Read the j-th of the integers of 8 bytes from an address on, without a look at bounds."""
    return ctypes.c_int64.from_address(int(address) + 8 * int(j)).value


def copy_cells(target: int, source: int, n: int) -> None:
    """Copy n cells of 8 bytes from an address to another one."""
    ctypes.memmove(int(target), int(source), 8 * int(n))


def pointer_to(address: int) -> Any:
    """Return an address as a pointer, from which arrays are made."""
    return ctypes.c_void_p(int(address))


_DOUBLE = ir.DoubleType()
_WIDEST = ir.IntType(64)


def _llvm(kind: int) -> Any:
    if kind in _FLOATS:
        return _DOUBLE if kind == FLOAT64 else ir.FloatType()
    return ir.IntType(8 * ctypes.sizeof(_CELLS[kind]))


def _cell(builder: Any, kind: int, address: Any, j: Any) -> Any:
    return builder.gep(builder.inttoptr(address, _llvm(kind).as_pointer()), [j])


def _to_double(builder: Any, kind: int, typed: Any) -> Any:
    if kind in _FLOATS:
        return typed if kind == FLOAT64 else builder.fpext(typed, _DOUBLE)
    return (builder.uitofp if kind in _UNSIGNED else builder.sitofp)(typed, _DOUBLE)


def _from_double(builder: Any, kind: int, value: Any) -> Any:
    if kind in _FLOATS:
        return value if kind == FLOAT64 else builder.fptrunc(value, _llvm(kind))
    if kind in _TRUTHS:
        return builder.zext(builder.fcmp_unordered("!=", value, _DOUBLE(0.0)), _llvm(kind))
    nearest = builder.call(builder.module.declare_intrinsic("llvm.rint", [_DOUBLE]), [value])
    whole = builder.fptosi(nearest, _WIDEST)
    return whole if _llvm(kind) == _WIDEST else builder.trunc(whole, _llvm(kind))


def _choose(builder: Any, kind: Any) -> Iterator[int]:
    """Enter a block for each type, and leave all to one that follows."""
    behind = builder.append_basic_block("behind")
    switch = builder.switch(kind, behind)
    for code in _CELLS:
        block = builder.append_basic_block(f"type_{code}")
        switch.add_case(kind.type(code), block)
        builder.position_at_end(block)
        yield code
        builder.branch(behind)
    builder.position_at_end(behind)


def copy_memory(builder: Any, target: Any, source: Any, n_bytes: Any) -> None:
    """Emit the copy of bytes from a pointer to another one."""
    byte = ir.IntType(8).as_pointer()
    copy = builder.module.declare_intrinsic("llvm.memcpy", [byte, byte, _WIDEST])
    places = [builder.bitcast(place, byte) for place in (target, source)]
    builder.call(copy, [*places, n_bytes, ir.IntType(1)(0)])


@emitted(load, "float64", *["int64"] * 3)
def _(builder: Any, arguments: list[Any]) -> Any:
    address, j, kind = arguments
    with builder.goto_entry_block():
        loaded = builder.alloca(_DOUBLE)
        builder.store(_DOUBLE(0.0), loaded)
    for code in _choose(builder, kind):
        typed = builder.load(_cell(builder, code, address, j))
        builder.store(_to_double(builder, code, typed), loaded)
    return builder.load(loaded)


@emitted(store, "none", *["int64"] * 3, "float64")
def _(builder: Any, arguments: list[Any]) -> None:
    address, j, kind, value = arguments
    for code in _choose(builder, kind):
        builder.store(_from_double(builder, code, value), _cell(builder, code, address, j))


@emitted(integer_at, "int64", "int64", "int64")
def _(builder: Any, arguments: list[Any]) -> Any:
    return builder.load(_cell(builder, INT64, *arguments))


@emitted(copy_cells, "none", *["int64"] * 3)
def _(builder: Any, arguments: list[Any]) -> None:
    to, start = (_cell(builder, INT64, address, _WIDEST(0)) for address in arguments[:2])
    copy_memory(builder, to, start, builder.mul(arguments[2], _WIDEST(LARGEST_SIZE)))


@emitted(pointer_to, "voidptr", "int64")
def _(builder: Any, arguments: list[Any]) -> Any:
    return builder.inttoptr(arguments[0], ir.IntType(8).as_pointer())
