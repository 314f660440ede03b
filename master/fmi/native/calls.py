"""
Calls of C functions by address, from Python and from compiled code alike.

Each function here has a Python form over ctypes and one for compiled code, a plain indirect call, so that
the one stepping loop runs compiled and uncompiled.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from llvmlite import ir

from .jit import emitted

_INT, _DOUBLE, _POINTER, _SIZE = ctypes.c_int, ctypes.c_double, ctypes.c_void_p, ctypes.c_size_t
_EXCHANGE = (_INT, _POINTER, _POINTER, _SIZE, _POINTER)
_STATE = (_INT, _POINTER, _POINTER)
_EXCHANGE_3 = (*_EXCHANGE, _SIZE)
CLOCK_TIME = (_INT, _INT, _POINTER)
CLOCK_SLEEP = (_INT, _INT, _INT, _POINTER, _POINTER)
MONOTONIC = 1  # CLOCK_MONOTONIC and TIMER_ABSTIME of Linux
ABSOLUTE = 1
_STEP = (_INT, _POINTER, _DOUBLE, _DOUBLE, _INT)
_STEP_3 = (_INT, _POINTER, _DOUBLE, _DOUBLE, ctypes.c_bool, *[_POINTER] * 4)


@lru_cache(maxsize=4096)
def _function(prototype: tuple[Any, ...], address: int) -> Callable[..., int]:
    return ctypes.CFUNCTYPE(*prototype)(address)


def exchange(address: int, component: int, references: int, n: int, values: int) -> int:
    """Call a setter or getter of FMI 2.0: (component, references, n, values) -> status."""
    return _function(_EXCHANGE, int(address))(int(component), int(references), int(n), int(values))


def exchange_3(address: int, component: int, references: int, n: int, values: int, n_values: int) -> int:
    """Call a setter or getter of FMI 3.0: (instance, references, n, values, n values) -> status."""
    given = map(int, (component, references, n, values, n_values))
    return _function(_EXCHANGE_3, int(address))(*given)


def do_step(address: int, component: int, t: float, h: float) -> int:
    """Call fmi2DoStep from t to t + h [s] -> status."""
    return _function(_STEP, int(address))(int(component), t, h, 1)


def do_step_3(address: int, component: int, t: float, h: float, answers: int) -> int:
    """
    Call fmi3DoStep from t to t + h [s] -> status.

    `answers` is the address of four cells of 8 bytes for eventHandlingNeeded, terminateSimulation,
    earlyReturn (Booleans of one byte) and lastSuccessfulTime (double).
    """
    places = [int(answers) + 8 * i for i in range(4)]
    return _function(_STEP_3, int(address))(int(component), t, h, True, *places)


def state(address: int, component: int, argument: int) -> int:
    """Call getter (argument: address of the cell to fill) or setter (the saved state) of an FMU's state."""
    return _function(_STATE, int(address))(int(component), int(argument))


def clock_time(address: int, place: int) -> int:
    """Call clock_gettime of the monotonic clock; `place` is the address of seconds and nanoseconds."""
    return _function(CLOCK_TIME, int(address))(MONOTONIC, int(place))


def clock_sleep(address: int, place: int) -> int:
    """Call clock_nanosleep until the absolute time [s, ns] at the address `place`."""
    return _function(CLOCK_SLEEP, int(address))(MONOTONIC, ABSOLUTE, int(place), 0)


_I64, _I32, _I1, _F64 = ir.IntType(64), ir.IntType(32), ir.IntType(1), ir.DoubleType()


def _indirect_call(builder: Any, address: Any, kinds: list[Any], arguments: list[Any]) -> Any:
    function = builder.inttoptr(address, ir.PointerType(ir.FunctionType(_I32, kinds)))
    return builder.sext(builder.call(function, arguments), _I64)


@emitted(exchange, "int64", *["int64"] * 5)
def _(builder: Any, arguments: list[Any]) -> Any:
    return _indirect_call(builder, arguments[0], [_I64] * 4, arguments[1:])


@emitted(exchange_3, "int64", *["int64"] * 6)
def _(builder: Any, arguments: list[Any]) -> Any:
    return _indirect_call(builder, arguments[0], [_I64] * 5, arguments[1:])


@emitted(do_step, "int64", "int64", "int64", "float64", "float64")
def _(builder: Any, arguments: list[Any]) -> Any:
    return _indirect_call(builder, arguments[0], [_I64, _F64, _F64, _I32], [*arguments[1:], _I32(1)])


@emitted(do_step_3, "int64", "int64", "int64", "float64", "float64", "int64")
def _(builder: Any, arguments: list[Any]) -> Any:
    *to_call, answers_at = arguments[1:]
    places = [builder.add(answers_at, _I64(8 * i)) for i in range(4)]
    kinds = [_I64, _F64, _F64, _I1, *[_I64] * 4]
    return _indirect_call(builder, arguments[0], kinds, [*to_call, _I1(1), *places])


@emitted(state, "int64", *["int64"] * 3)
def _(builder: Any, arguments: list[Any]) -> Any:
    return _indirect_call(builder, arguments[0], [_I64] * 2, arguments[1:])


@emitted(clock_time, "int64", "int64", "int64")
def _(builder: Any, arguments: list[Any]) -> Any:
    return _indirect_call(builder, arguments[0], [_I32, _I64], [_I32(MONOTONIC), arguments[1]])


@emitted(clock_sleep, "int64", "int64", "int64")
def _(builder: Any, arguments: list[Any]) -> Any:
    given = [_I32(MONOTONIC), _I32(ABSOLUTE), arguments[1], _I64(0)]
    return _indirect_call(builder, arguments[0], [_I32, _I32, _I64, _I64], given)
