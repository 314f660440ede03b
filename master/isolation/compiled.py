"""
The compiled functions of both sides, at addresses: kept on disk between processes, as the stepping loop is.

A setter or getter of FMI does not say of which type it is: so each type has a small function of its own that
adds it and goes on to the one `exchange`.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from llvmlite import binding, ir

from master.fmi.description import Kind
from master.fmi.native.cells import size_of
from master.fmi.native.kept_code import MachineCode, compile_code, digest_of, kept_file, load_code
from master.fmi.value_types import BOOLEAN, FLOAT32, FLOAT64, INT32, INT_BOOLEAN
from master.installation import cache_folder

from . import serve, stub

PACKAGE = Path(__file__).parents[1]
SOURCES = (
    "isolation/compiled",
    "isolation/layout",
    "isolation/serve",
    "isolation/stub",
    "fmi/native/calls",
    "fmi/native/cells",
    "fmi/native/float_mode",
    "fmi/native/jit",
    "fmi/native/sharing",
    "fmi/value_types",
    "process/position",
)
"""All files whose code is compiled; a test compares them with what they import."""

_SIGNATURES: dict[Any, str] = {
    stub.exchange: "int32(int64, int64, int64, int64, int64, int64, int64, int64)",
    stub.step_2: "int32(int64, float64, float64, int32)",
    stub.step_3: "int32(int64, float64, float64, uint8, int64, int64, int64, int64)",
    stub.save: "int32(int64, int64)",
    stub.restore: "int32(int64, int64)",
    stub.free: "int32(int64, int64)",
    stub.ask: "int32(int64, int64)",
    serve.serve: "int64(int64)",
}

Typed = Mapping[tuple[Kind, int], int]


@dataclass(frozen=True)
class Functions:
    """
    Addresses of the functions in the form of FMI, and what Python calls.

    `setters` and `getters`: by FMI version, then kind and value type.
    """

    setters: Mapping[int, Typed]
    getters: Mapping[int, Typed]
    step: Mapping[int, int]
    save: int
    restore: int
    free: int
    ask: Callable[[int, int], int]
    serve: Callable[[int], int]
    keep_alive: tuple[Any, ...]


@lru_cache(maxsize=1)
def functions() -> Functions:
    """Compile the functions, or load them from where they are kept."""
    made = {function.__name__: _code(function, text) for function, text in _SIGNATURES.items()}
    at = {name: one.address for name, one in made.items()}
    engine = _typed_functions(at["exchange"])
    typed = {
        what: {
            version: {pair: engine.get_function_address(_name(what, version, pair[1])) for pair in pairs}
            for version, pairs in _pairs().items()
        }
        for what in ("set", "get")
    }
    return Functions(
        setters=typed["set"],
        getters=typed["get"],
        step={2: at["step_2"], 3: at["step_3"]},
        save=at["save"],
        restore=at["restore"],
        free=at["free"],
        ask=ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_int64, ctypes.c_int64)(at["ask"]),
        serve=ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64)(at["serve"]),
        keep_alive=(made, engine),
    )


def _code(function: Callable[..., int], signature: str) -> MachineCode:
    file = kept_file(cache_folder(), f"isolated-{function.__name__}", digest_of_sources())
    return load_code(file) or compile_code(file, signature, function)


@lru_cache(maxsize=1)
def digest_of_sources() -> str:
    """Digest of all files whose code is compiled."""
    return digest_of([PACKAGE / f"{name}.py" for name in SOURCES])


def _pairs() -> dict[int, list[tuple[Kind, int]]]:
    """Kinds and value types that each version exchanges."""
    two = [(Kind.REAL, FLOAT64), (Kind.INTEGER, INT32), (Kind.BOOLEAN, INT_BOOLEAN)]
    return {2: two, 3: [(_kind(code), code) for code in range(BOOLEAN + 1)]}


def _kind(code: int) -> Kind:
    if code in (FLOAT64, FLOAT32):
        return Kind.REAL
    return Kind.BOOLEAN if code == BOOLEAN else Kind.INTEGER


def _name(what: str, version: int, code: int) -> str:
    return f"{what}_{version}_{code}"


def _typed_functions(exchange: int) -> Any:
    """Emit the setter and getter of each type of both versions."""
    word, status = ir.IntType(64), ir.IntType(32)
    module = ir.Module(name="isolated_values")
    module.triple = binding.get_process_triple()
    target = ir.FunctionType(status, [word] * 8).as_pointer()
    for version, pairs in _pairs().items():
        n_arguments = 4 if version == 2 else 5
        for is_get, what in enumerate(("set", "get")):
            for _, code in pairs:
                kind = ir.FunctionType(status, [word] * n_arguments)
                function = ir.Function(module, kind, _name(what, version, code))
                builder = ir.IRBuilder(function.append_basic_block())
                desk, references, n, values = function.args[:4]
                n_values = n if version == 2 else function.args[4]
                fixed = [word(is_get), word(code), word(size_of(code))]
                to = builder.inttoptr(word(exchange), target)
                builder.ret(builder.call(to, [*fixed, desk, references, n, values, n_values]))
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    machine = binding.Target.from_default_triple().create_target_machine()
    engine = binding.create_mcjit_compiler(binding.parse_assembly(str(module)), machine)
    engine.finalize_object()
    return engine
