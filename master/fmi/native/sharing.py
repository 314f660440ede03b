"""
Memory that two processes share, from compiled code: words in order, calls of the kernel, waiting.

A word is 32 bits. The side that waits looks for a while, then sleeps on the word (futex); the other side
wakes it only if it says that it sleeps. Linux alone, on processors of 64 bits.
"""

from __future__ import annotations

import ctypes
import platform
from typing import Any, NamedTuple

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .cells import integer_at
from .jit import inner


class _Numbers(NamedTuple):
    """Numbers of calls of the kernel."""

    sched_yield: int
    wait4: int
    kill: int
    futex: int
    clock_gettime: int
    getppid: int


_BY_MACHINE = {
    "x86_64": _Numbers(24, 61, 62, 202, 228, 110),
    "aarch64": _Numbers(124, 260, 129, 98, 113, 173),
}
_MACHINE = platform.machine()
SCHED_YIELD, WAIT4, KILL, FUTEX, CLOCK_GETTIME, GETPPID = _BY_MACHINE.get(_MACHINE, _Numbers(*[-1] * 6))

_FUTEX_WAIT = 0
_FUTEX_WAKE = 1
_CLOCK_MONOTONIC = 1
_LOOKS_A_YIELD = 20
_SECOND = 1_000_000_000  # ns

_emitted: Any = intrinsic  # callers pass all arguments but the first

_I32, _I64, _WORD = ir.IntType(32), ir.IntType(64), ir.IntType(32).as_pointer()


def kernel_entry() -> int:
    """Address of the C library's `syscall`, which differs from process to process."""
    return ctypes.cast(ctypes.CDLL(None).syscall, ctypes.c_void_p).value or 0


@_emitted  # type: ignore[untyped-decorator]
def load_word(typing: Any, address: Any) -> Any:
    """Read a word; nothing that the program reads later is read before it."""

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        place = builder.inttoptr(arguments[0], _WORD)
        return builder.zext(builder.load_atomic(place, "seq_cst", 4), _I64)

    return types.int64(types.int64), generate


@_emitted  # type: ignore[untyped-decorator]
def store_word(typing: Any, address: Any, value: Any) -> Any:
    """Write a word; all that the program wrote before it is seen with it."""

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        place = builder.inttoptr(arguments[0], _WORD)
        builder.store_atomic(builder.trunc(arguments[1], _I32), place, "seq_cst", 4)
        return context.get_dummy_value()

    return types.none(types.int64, types.int64), generate


@_emitted  # type: ignore[untyped-decorator]
def _pause(typing: Any) -> Any:
    """Tell the processor that this is a loop which waits."""

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        hint = "pause" if _MACHINE == "x86_64" else "yield"
        code = ir.InlineAsm(ir.FunctionType(ir.VoidType(), []), hint, "~{memory}", side_effect=True)
        builder.call(code, [])
        return context.get_dummy_value()

    return types.none(), generate


@_emitted  # type: ignore[untyped-decorator]
def kernel(typing: Any, entry: Any, number: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
    """Make a call of the kernel with up to four arguments through `kernel_entry()`; -1 if it fails."""

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        kind = ir.FunctionType(_I64, [_I64], var_arg=True)
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        return builder.call(function, [*arguments[1:], _I64(0), _I64(0)])

    return types.int64(*[types.int64] * 6), generate


@_emitted  # type: ignore[untyped-decorator]
def copy_bytes(typing: Any, target: Any, source: Any, n: Any) -> Any:
    """Copy n bytes from an address to another one."""

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        byte = ir.IntType(8).as_pointer()
        to, start = (builder.inttoptr(address, byte) for address in arguments[:2])
        cgutils.raw_memcpy(builder, to, start, arguments[2], 1)  # type: ignore[no-untyped-call]
        return context.get_dummy_value()

    return types.none(*[types.int64] * 3), generate


@_emitted  # type: ignore[untyped-decorator]
def put_integer(typing: Any, address: Any, j: Any, value: Any) -> Any:
    """Write the j-th of the integers of 8 bytes from an address on."""

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        first = builder.inttoptr(arguments[0], _I64.as_pointer())
        builder.store(arguments[2], builder.gep(first, [arguments[1]]))
        return context.get_dummy_value()

    return types.none(*[types.int64] * 3), generate


@inner
def now(entry: int, scratch: int) -> int:
    """Return the time of the monotonic clock [ns]; `scratch` is the address of two free cells."""
    kernel(entry, CLOCK_GETTIME, _CLOCK_MONOTONIC, scratch, 0, 0)
    return integer_at(scratch, 0) * _SECOND + integer_at(scratch, 1)


@inner
def looked(entry: int, word: int, seen: int, looks: int) -> bool:
    """Look at a word until it is another one than `seen`, at most `looks` times; whether it is."""
    for i in range(looks):
        if load_word(word) != seen:
            return True
        _pause()
        if i % _LOOKS_A_YIELD == _LOOKS_A_YIELD - 1:
            kernel(entry, SCHED_YIELD, 0, 0, 0, 0)
    return bool(load_word(word) != seen)


@inner
def sleep_on(entry: int, word: int, sleeps: int, seen: int, nanoseconds: int, scratch: int) -> None:
    """
    Sleep until a word is another one than `seen`, at most for a while.

    `sleeps` is the address of the word that says so; `scratch` that of two free cells.
    """
    put_integer(scratch, 0, nanoseconds // _SECOND)
    put_integer(scratch, 1, nanoseconds % _SECOND)
    store_word(sleeps, 1)
    if load_word(word) == seen:
        kernel(entry, FUTEX, word, _FUTEX_WAIT, seen, scratch)
    store_word(sleeps, 0)


@inner
def publish(entry: int, word: int, sleeps: int, value: int) -> None:
    """Write a word, and wake the side that sleeps on it."""
    store_word(word, value)
    if load_word(sleeps) != 0:
        kernel(entry, FUTEX, word, _FUTEX_WAKE, 1, 0)
