"""
Calls of C functions by address, from Python and from numba-compiled code alike.

Each function here has a Python form over ctypes and an overload that numba compiles into a plain
indirect call, so that the one stepping loop runs compiled and uncompiled.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, overload

FLOAT64, INT32, BOOL32 = 0, 1, 2

_INT, _DOUBLE, _POINTER, _SIZE = ctypes.c_int, ctypes.c_double, ctypes.c_void_p, ctypes.c_size_t
_EXCHANGE = (_INT, _POINTER, _POINTER, _SIZE, _POINTER)
_STEP = (_INT, _POINTER, _DOUBLE, _DOUBLE, _INT)


@lru_cache(maxsize=4096)
def _function(prototype: tuple[Any, ...], address: int) -> Callable[..., int]:
    return ctypes.CFUNCTYPE(*prototype)(address)


def exchange(address: int, component: int, references: int, n: int, values: int) -> int:
    """Call a setter or getter of FMI 2.0: (component, references, n, values) -> status."""
    return _function(_EXCHANGE, int(address))(int(component), int(references), int(n), int(values))


def do_step(address: int, component: int, t: float, h: float) -> int:
    """Call fmi2DoStep from t to t + h [s] -> status."""
    return _function(_STEP, int(address))(int(component), t, h, 1)


def _indirect_call(context: Any, builder: Any, address: Any, kinds: list[Any], arguments: list[Any]) -> Any:
    signature = ir.FunctionType(ir.IntType(32), kinds)
    function = builder.inttoptr(address, ir.PointerType(signature))
    return builder.call(function, arguments)


@intrinsic
def _exchange_compiled(
    typing: Any, address: Any, component: Any, references: Any, n: Any, values: Any
) -> Any:
    signature = types.int32(types.int64, types.int64, types.int64, types.int64, types.int64)

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        kinds = [ir.IntType(64)] * 4
        return _indirect_call(context, builder, arguments[0], kinds, list(arguments[1:]))

    return signature, generate


@intrinsic
def _do_step_compiled(typing: Any, address: Any, component: Any, t: Any, h: Any) -> Any:
    signature = types.int32(types.int64, types.int64, types.float64, types.float64)

    def generate(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        kinds = [ir.IntType(64), ir.DoubleType(), ir.DoubleType(), ir.IntType(32)]
        keep_no_old_state = cgutils.int32_t(1)
        return _indirect_call(context, builder, arguments[0], kinds, [*arguments[1:], keep_no_old_state])

    return signature, generate


# numba compares the parameters of both forms, annotations included: so there are none here.
@overload(exchange)
def _(address, component, references, n, values):
    return lambda address, component, references, n, values: _exchange_compiled(
        address, component, references, n, values
    )


@overload(do_step)
def _(address, component, t, h):
    return lambda address, component, t, h: _do_step_compiled(address, component, t, h)
