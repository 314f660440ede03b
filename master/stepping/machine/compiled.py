"""
The stepping loop as compiled code, kept on disk between processes.

It is kept in the cache of this installation, or where NUMBA_CACHE_DIR says; where nothing can be written, it
is compiled for this process alone. Two things must never happen: that code of an older source is loaded, and
that damaged code is.

* numba looks at the time of this file alone, not at those that the loop calls. So a digest of all of them
  is a constant of the compiled function, in its closure, which numba makes part of the key of its cache.
* numba loads what is in its files without a look: see `CacheFiles`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from master.fmi.native.kept_code import CacheFiles, digest_of, kept_in
from master.installation import cache_folder
from master.process import position
from master.system.channel import Channel

from .interpreter import Execution, execute, finite_only, is_plain
from .program import (
    BLOCK_WIDTH,
    CONVERSION_WIDTH,
    COPY_WIDTH,
    FEED_WIDTH,
    LOOP_WIDTH,
    MAP_WIDTH,
    OPERATION_WIDTH,
    RESIDUAL_WIDTH,
    SLAVE_WIDTH,
    Memory,
)

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

Execute = Callable[..., Execution]


def digest_of_sources() -> int:
    """Digest of all files whose code is compiled, 63 bits."""
    return digest_of([PACKAGE / f"{name}.py" for name in SOURCES])


@lru_cache(maxsize=1)
def compiled() -> Execute:
    """Return `execute` as compiled code: it takes the same arguments but `general`, `pace` by its name."""
    dispatcher = _dispatcher(digest_of_sources())
    if not hasattr(dispatcher, "stats"):  # NUMBA_DISABLE_JIT=1
        return lambda *arguments, pace=None: dispatcher(*arguments, True, pace)
    path = dispatcher.stats.cache_path
    files = CacheFiles(None if path is None else Path(path), "compiled.*keyed*")
    files.drop_damaged()

    def run(memory: Memory, *arguments: Any, pace: int | None = None) -> Execution:
        known = len(dispatcher.overloads)
        result: Execution = dispatcher(memory, *arguments, None if is_plain(memory) else True, pace)
        if len(dispatcher.overloads) > known:
            files.note_digests()
        return result

    return run


def load_plain() -> None:
    """Load the code for plain programs, so that processes forked from this one have it."""
    tables = (
        OPERATION_WIDTH, BLOCK_WIDTH, SLAVE_WIDTH, COPY_WIDTH, CONVERSION_WIDTH, MAP_WIDTH, FEED_WIDTH,
    )  # fmt: skip
    operations, blocks, slaves, copies, conversions, maps, feeds = (
        np.zeros((0, width), dtype=np.int64) for width in tables
    )
    none = np.zeros(0)
    memory = Memory(
        operations=operations,
        blocks=blocks,
        slaves=slaves,
        copies=copies,
        conversions=conversions.astype(np.float64),
        maps=maps.astype(np.float64),
        feeds=feeds,
        measured=np.zeros((0, 0)),
        values=none,
        rings=none.copy(),
        states=np.zeros(0, dtype=np.int64),
        loops=np.zeros((0, LOOP_WIDTH), dtype=np.int64),
        residuals=np.zeros((0, RESIDUAL_WIDTH), dtype=np.int64),
        tolerances=none.copy(),
        channels=np.zeros((0, len(Channel))),
        position=np.asarray(position.current().cells),
    )
    compiled()(memory, finite_only(np.zeros(0, dtype=np.int64)), 0.0, 1.0, 0, 0, np.zeros((0, 0)))


def _dispatcher(digest: int) -> Any:
    """Compile a function whose closure holds the digest, so that it is part of the key of numba's cache."""
    from numba import njit

    def keyed(memory, monitor, t0, h, begin, end, rows, general, pace):  # type: ignore[no-untyped-def]  # noqa: PLR0913
        if digest < 0:
            return execute(memory, monitor, t0, h, begin, begin, rows, general, pace)
        return execute(memory, monitor, t0, h, begin, end, rows, general, pace)

    with kept_in(cache_folder()):
        try:
            return njit(cache=True, error_model="numpy")(keyed)
        except RuntimeError:  # no place to keep it
            return njit(error_model="numpy")(keyed)
