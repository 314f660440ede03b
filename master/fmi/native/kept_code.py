"""
Machine code that numba compiled, kept on disk between processes.

It is kept in the cache of this installation, or where NUMBA_CACHE_DIR says; where nothing can be written, it
is compiled for each process. Loading it takes LLVM alone: numba itself is imported where something has to be
compiled. Two things must never happen: that code of an older source, of another numba or for another
processor is loaded, and that damaged code is. So the name of a file has a digest of all these, and its first
line one of what follows.

    digest of the rest, function, names of what it calls      (three lines)
    object code of LLVM
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from llvmlite import binding

from .jit import tell_numba

binding.initialize_native_target()
binding.initialize_native_asmprinter()
_C = ctypes.cdll.msvcrt if sys.platform == "win32" else ctypes.CDLL(None)


@dataclass(frozen=True)
class MachineCode:
    """Compiled code in memory, as long as this lives."""

    address: int
    keep_alive: Any


@dataclass(frozen=True)
class _Object:
    """Object code, the name of its function, and what it calls."""

    code: bytes
    function: str
    calls: tuple[str, ...]

    def written(self) -> bytes:
        """Return the contents of a file of it."""
        rest = f"{self.function}\n{' '.join(self.calls)}\n".encode() + self.code
        return _digest(rest) + b"\n" + rest

    @classmethod
    def read(cls, contents: bytes) -> _Object | None:
        """Return what a file holds, None where it is not what was written."""
        digest, _, rest = contents.partition(b"\n")
        if digest != _digest(rest):
            return None
        function, calls, code = rest.split(b"\n", 2)
        return cls(code, function.decode(), tuple(calls.decode().split()))


def digest_of(sources: Sequence[Path]) -> str:
    """Digest of files, and of what else the code that numba makes of them depends on."""
    texts = [source.read_bytes() for source in sources]
    makers = [version("numba"), version("llvmlite"), platform.python_version()]
    processor = [
        binding.get_process_triple(),
        binding.get_host_cpu_name(),
        binding.get_host_cpu_features().flatten(),
    ]
    return hashlib.sha256(b"\0".join([*texts, *map(str.encode, makers + processor)])).hexdigest()[:32]


def kept_file(cache: Path, name: str, digest: str) -> Path:
    """Return the file in a cache for code with a name and a digest, see `digest_of`."""
    return Path(os.environ.get("NUMBA_CACHE_DIR") or cache / "compiled") / f"{name}-{digest}.o"


def load_code(file: Path) -> MachineCode | None:
    """Load what a file keeps, None if nothing is."""
    try:
        kept = _Object.read(file.read_bytes())
    except OSError:
        return None
    return None if kept is None else _loaded(kept)


def compile_code(file: Path, signature: str, function: Callable[..., Any]) -> MachineCode:
    """Compile a function, and keep it in a file; its signature is as for numba's `cfunc`."""
    from numba import cfunc

    tell_numba()
    made: Any = cfunc(signature, error_model="numpy")(function)
    library = made._library  # numba has no public way to object code
    module = library._final_module
    declared = [part.name for part in (*module.functions, *module.global_variables) if part.is_declaration]
    calls = tuple(name for name in declared if not name.startswith("llvm."))
    _write(file, _Object(library._get_compiled_object(), made.native_name, calls).written())
    return MachineCode(made.address, made)


def _loaded(kept: _Object) -> MachineCode | None:
    """Load object code; None where something that it calls is not here: LLVM would end the process."""
    if not all(map(_is_here, kept.calls)):
        return None
    engine = _engine()
    engine.add_object_file(binding.ObjectFileRef.from_data(kept.code))
    engine.finalize_object()
    return MachineCode(engine.get_function_address(kept.function), engine)


def _engine() -> Any:
    machine = binding.Target.from_default_triple().create_target_machine()
    return binding.create_mcjit_compiler(binding.parse_assembly(""), machine)


@lru_cache(maxsize=256)
def _is_here(symbol: str) -> bool:
    """Whether LLVM finds a function or datum, after it has been told of those of Python and numba."""
    if binding.address_of_symbol(symbol) is not None:
        return True
    if symbol.startswith(("numba_", "NRT_")):  # for exceptions and memory, which this code does without
        place = ctypes.cast(_C.abort, ctypes.c_void_p).value
    elif hasattr(ctypes.pythonapi, symbol):
        place = ctypes.addressof(ctypes.c_byte.in_dll(ctypes.pythonapi, symbol))
    else:
        return False
    binding.add_symbol(symbol, place)
    return True


def _write(file: Path, contents: bytes) -> None:
    """Write a file as a whole, or not at all: the next process compiles again then."""
    new = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        new.write_bytes(contents)
        new.replace(file)
    except OSError:
        with suppress(OSError):
            new.unlink()


def _digest(contents: bytes) -> bytes:
    return hashlib.sha256(contents).hexdigest().encode()
