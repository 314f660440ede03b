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

from .cells import copy_memory, integer_at
from .jit import emitted, inner


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

_I32, _I64, _WORD = ir.IntType(32), ir.IntType(64), ir.IntType(32).as_pointer()


def kernel_entry() -> int:
    """Address of the C library's `syscall`, which differs from process to process."""
    return ctypes.cast(ctypes.CDLL(None).syscall, ctypes.c_void_p).value or 0


def load_word(address: int) -> int:
    """Read a word; nothing that the program reads later is read before it."""
    raise _only_compiled()


def store_word(address: int, value: int) -> None:
    """Write a word; all that the program wrote before it is seen with it."""
    raise _only_compiled()


def kernel(entry: int, number: int, a: int, b: int, c: int, d: int) -> int:
    """Make a call of the kernel with up to four arguments through `kernel_entry()`; -1 if it fails."""
    raise _only_compiled()


def copy_bytes(target: int, source: int, n: int) -> None:
    """Copy n bytes from an address to another one."""
    raise _only_compiled()


def put_integer(address: int, j: int, value: int) -> None:
    """Write the j-th of the integers of 8 bytes from an address on."""
    raise _only_compiled()


def _pause() -> None:
    """Tell the processor that this is a loop which waits."""
    raise _only_compiled()


def _only_compiled() -> RuntimeError:
    return RuntimeError("both sides of shared memory are compiled code, got a call from Python")


@emitted(load_word, "int64", "int64")
def _(builder: Any, arguments: list[Any]) -> Any:
    place = builder.inttoptr(arguments[0], _WORD)
    return builder.zext(builder.load_atomic(place, "seq_cst", 4), _I64)


@emitted(store_word, "none", "int64", "int64")
def _(builder: Any, arguments: list[Any]) -> None:
    place = builder.inttoptr(arguments[0], _WORD)
    builder.store_atomic(builder.trunc(arguments[1], _I32), place, "seq_cst", 4)


@emitted(_pause, "none")
def _(builder: Any, _: list[Any]) -> None:
    hint = "pause" if _MACHINE == "x86_64" else "yield"
    code = ir.InlineAsm(ir.FunctionType(ir.VoidType(), []), hint, "~{memory}", side_effect=True)
    builder.call(code, [])


@emitted(kernel, "int64", *["int64"] * 6)
def _(builder: Any, arguments: list[Any]) -> Any:
    kind = ir.FunctionType(_I64, [_I64], var_arg=True)
    function = builder.inttoptr(arguments[0], kind.as_pointer())
    return builder.call(function, [*arguments[1:], _I64(0), _I64(0)])


@emitted(copy_bytes, "none", *["int64"] * 3)
def _(builder: Any, arguments: list[Any]) -> None:
    byte = ir.IntType(8).as_pointer()
    to, start = (builder.inttoptr(address, byte) for address in arguments[:2])
    copy_memory(builder, to, start, arguments[2])


@emitted(put_integer, "none", *["int64"] * 3)
def _(builder: Any, arguments: list[Any]) -> None:
    first = builder.inttoptr(arguments[0], _I64.as_pointer())
    builder.store(arguments[2], builder.gep(first, [arguments[1]]))


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
