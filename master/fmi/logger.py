"""
The logger of FMI 2.0, a C function with variable arguments, which Python cannot provide: so it is compiled.

The compiled function passes its arguments on, the variable ones as the address of a `va_list`.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from llvmlite import binding, ir

from .printf import CUT, LONGEST, UnreadableError, filled_in, text_at

_P, _INT = ctypes.c_void_p, ctypes.c_int
_RECEIVER = ctypes.CFUNCTYPE(None, _P, _P, _INT, _P, _P, _P)
_VA_LIST_BYTES = 64  # more than any platform needs

Note = Callable[[int, str, str], None]  # status, category, text

_instances: dict[int, Note] = {}
_last_key = 0


def add(note: Note) -> int:
    """Register what takes the messages of an instance; return its `componentEnvironment`."""
    global _last_key
    _last_key += 1
    _instances[_last_key] = note
    return _last_key


def remove(environment: int) -> None:
    """End what `add` began."""
    _instances.pop(environment, None)


def _receive(
    environment: int | None, _: int | None, status: int, category: int | None, text: int | None, rest: int
) -> None:
    note = _instances.get(environment or 0)
    is_given = 0 < (environment or 0) <= _last_key
    if not is_given and len(_instances) == 1:  # an FMU that passes something else
        [note] = _instances.values()
    if note is not None:
        note(status, _read(category), _read(text, rest))


def _read(address: int | None, arguments: int = 0) -> str:
    """Return the text at an address, filled in where there are arguments, and cut with a note."""
    if address is None:
        return ""
    try:
        text, is_whole = text_at(address)
    except UnreadableError as error:
        return f"({error} cannot be read)"
    if not is_whole:
        return text + CUT
    text = filled_in(text, arguments) if arguments else text
    return text if len(text) <= 2 * LONGEST else text[:LONGEST] + CUT


@lru_cache(maxsize=1)
def _compiled() -> tuple[int, Any]:
    receiver = _RECEIVER(_receive)
    pointer, integer, word = ir.IntType(8).as_pointer(), ir.IntType(32), ir.IntType(64)
    fixed = [pointer, pointer, integer, pointer, pointer]
    module = ir.Module(name="logger")
    module.triple = binding.get_process_triple()
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), fixed, var_arg=True), "dockloop_logger")
    builder = ir.IRBuilder(function.append_basic_block())
    place = builder.alloca(ir.ArrayType(ir.IntType(8), _VA_LIST_BYTES))
    place.align = 16
    rest = builder.bitcast(place, pointer)
    on_lists = ir.FunctionType(ir.VoidType(), [pointer])
    builder.call(ir.Function(module, on_lists, "llvm.va_start"), [rest])
    passing = ir.FunctionType(ir.VoidType(), [*fixed, pointer]).as_pointer()
    target = builder.inttoptr(word(ctypes.cast(receiver, _P).value), passing)
    builder.call(target, [*function.args, rest])
    builder.call(ir.Function(module, on_lists, "llvm.va_end"), [rest])
    builder.ret_void()
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    machine = binding.Target.from_default_triple().create_target_machine()
    engine = binding.create_mcjit_compiler(binding.parse_assembly(str(module)), machine)
    engine.finalize_object()
    return engine.get_function_address("dockloop_logger"), (receiver, engine)


def address() -> int:
    """Address of the logger, the same one for all instances."""
    return _compiled()[0]
