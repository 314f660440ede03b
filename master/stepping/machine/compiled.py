"""
The stepping loop as compiled code, kept on disk between processes.

It is kept in the cache of this installation, or where NUMBA_CACHE_DIR says; where nothing can be written, it
is compiled for this process alone. Two things must never happen: that code of an older source is loaded, and
that damaged code is.

* numba looks at the time of this file alone, not at those that the loop calls. So a digest of all of them
  is a constant of the compiled function, in its closure, which numba makes part of the key of its cache.
* numba loads what is in its files without a look. So the digest of each is written next to it when it is
  made, and a file without the right one is removed before it is loaded; numba compiles again then.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

from master.installation import cache_folder

from .interpreter import Execution, execute, is_plain
from .program import Memory

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

_CHECKED = ".sha256"

Execute = Callable[..., Execution]


def digest_of_sources() -> int:
    """Digest of all files whose code is compiled, 63 bits."""
    texts = [(PACKAGE / f"{name}.py").read_bytes() for name in SOURCES]
    return int.from_bytes(hashlib.sha256(b"\0".join(texts)).digest()[:8], "big") >> 1


@lru_cache(maxsize=1)
def compiled() -> Execute:
    """Return `execute` as compiled code: it takes the same arguments but `general`, `pace` by its name."""
    dispatcher = _dispatcher(digest_of_sources())
    if not hasattr(dispatcher, "stats"):  # NUMBA_DISABLE_JIT=1
        return lambda *arguments, pace=None: dispatcher(*arguments, True, pace)
    files = CacheFiles(dispatcher)
    files.drop_damaged()

    def run(memory: Memory, *arguments: Any, pace: int | None = None) -> Execution:
        known = len(dispatcher.signatures)
        result: Execution = dispatcher(memory, *arguments, None if is_plain(memory) else True, pace)
        if len(dispatcher.signatures) > known:
            files.note_digests()
        return result

    return run


def _dispatcher(digest: int) -> Any:
    """Compile a function whose closure holds the digest, so that it is part of the key of numba's cache."""
    from numba import config, njit

    def keyed(memory, monitor, t0, h, begin, end, rows, general, pace):  # type: ignore[no-untyped-def]  # noqa: PLR0913
        if digest < 0:
            return execute(memory, monitor, t0, h, begin, begin, rows, general, pace)
        return execute(memory, monitor, t0, h, begin, end, rows, general, pace)

    settings: Any = config
    of_the_user = settings.CACHE_DIR  # for all that this process compiles
    settings.CACHE_DIR = of_the_user or str(cache_folder() / "numba")
    try:
        return njit(cache=True, error_model="numpy")(keyed)
    except RuntimeError:  # no place to keep it
        return njit(error_model="numpy")(keyed)
    finally:
        settings.CACHE_DIR = of_the_user


class CacheFiles:
    """Files in which numba keeps a function."""

    def __init__(self, dispatcher: Any) -> None:
        path = dispatcher.stats.cache_path
        self.folder = None if path is None else Path(path)

    def drop_damaged(self) -> None:
        """Remove files whose digest is missing or another one."""
        for file in self._files():
            try:
                if file.with_name(file.name + _CHECKED).read_text(encoding="ascii") == _digest(file):
                    continue
            except (OSError, UnicodeDecodeError):
                pass
            _remove(file)

    def note_digests(self) -> None:
        """Write the digest of each file next to it."""
        for file in self._files():
            try:
                file.with_name(file.name + _CHECKED).write_text(_digest(file), encoding="ascii")
            except OSError:
                continue  # without it the file is removed before it is loaded

    def _files(self) -> list[Path]:
        if self.folder is None:
            return []
        return [f for kind in ("nbi", "nbc") for f in self.folder.glob(f"compiled.*keyed*.{kind}")]


def _digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _remove(file: Path) -> None:
    try:
        file.unlink()
    except OSError:
        return
