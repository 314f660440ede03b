"""
The floating-point mode of the processor: rounding, traps, flush to zero.

An FMU may change it, on purpose or as its library was built with `-ffast-math`; what other FMUs and the
master compute would then differ. So it is set back after each turn of an FMU to what C begins with.
"""

from __future__ import annotations

import ctypes
import platform
import sys
from functools import lru_cache
from typing import Any

from llvmlite import binding, ir

from .jit import emitted

_MACHINE = platform.machine().lower()
_IS_X86 = _MACHINE in ("x86_64", "amd64")
_IS_ARM = _MACHINE in ("aarch64", "arm64")
_DEFAULT = 0x1F80 if _IS_X86 else 0  # MXCSR with all traps masked; FPCR
_CONTROL = 0xFFC0 if _IS_X86 else 0xFFFFFFFF  # without the flags of what has happened

binding.initialize_native_target()
binding.initialize_native_asmprinter()
binding.initialize_native_asmparser()

_I32, _I64, _VOID = ir.IntType(32), ir.IntType(64), ir.VoidType()
_BYTES = ir.IntType(8).as_pointer()


def restore_float_mode() -> int:
    """Set the mode back; return whether it was another one."""
    return int(_compiled()())


def _build(builder: Any) -> Any:
    """Emit the code of `restore_float_mode`, with an integer of 32 bits as its value."""
    if _IS_X86:
        return _build_x86(builder)
    return _build_arm(builder) if _IS_ARM else _I32(0)


def _declared(builder: Any, name: str, result: Any, *parameters: Any) -> Any:
    found = builder.module.globals.get(name)
    return found or ir.Function(builder.module, ir.FunctionType(result, parameters), name)


def _build_x86(builder: Any) -> Any:
    with builder.goto_entry_block():
        cell = builder.alloca(_I32)
    place = builder.bitcast(cell, _BYTES)
    builder.call(_declared(builder, "llvm.x86.sse.stmxcsr", _VOID, _BYTES), [place])
    control = builder.and_(builder.load(cell), _I32(_CONTROL))
    differs = builder.icmp_unsigned("!=", control, _I32(_DEFAULT))
    with builder.if_then(differs, likely=False):
        builder.store(_I32(_DEFAULT), cell)
        builder.call(_declared(builder, "llvm.x86.sse.ldmxcsr", _VOID, _BYTES), [place])
        if sys.platform != "win32":  # there the x87 unit begins with another mode
            initialise = ir.InlineAsm(
                ir.FunctionType(_VOID, []), "fninit", "~{st},~{memory}", side_effect=True
            )
            builder.call(initialise, [])
    return builder.zext(differs, _I32)


def _build_arm(builder: Any) -> Any:
    mode = builder.call(_declared(builder, "llvm.aarch64.get.fpcr", _I64), [])
    differs = builder.icmp_unsigned("!=", builder.and_(mode, _I64(_CONTROL)), _I64(_DEFAULT))
    with builder.if_then(differs, likely=False):
        builder.call(_declared(builder, "llvm.aarch64.set.fpcr", _VOID, _I64), [_I64(_DEFAULT)])
    return builder.zext(differs, _I32)


@lru_cache(maxsize=1)
def _compiled() -> Any:
    module = ir.Module(name="float_mode")
    module.triple = binding.get_process_triple()
    function = ir.Function(module, ir.FunctionType(_I32, []), "restore_float_mode")
    builder = ir.IRBuilder(function.append_basic_block())
    builder.ret(_build(builder))
    machine = binding.Target.from_default_triple().create_target_machine()
    engine = binding.create_mcjit_compiler(binding.parse_assembly(str(module)), machine)
    engine.finalize_object()
    called = ctypes.CFUNCTYPE(ctypes.c_int32)(engine.get_function_address("restore_float_mode"))
    called.engine = engine  # type: ignore[attr-defined]  # keeps the code
    return called


@emitted(restore_float_mode, "int32")
def _(builder: Any, _: list[Any]) -> Any:
    return _build(builder)
