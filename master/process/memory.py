"""Memory that this process shares with those that it forks, and what is done where there is too little."""

from __future__ import annotations

import errno
import math
import mmap
import os
import sys
import weakref

from master.errors import MasterError

MORE_MEMORY = "expected more address space (`ulimit -v`), or fewer rows and signals"
TOO_LITTLE_MEMORY = f"memory: there is too little, {MORE_MEMORY}"

_alive: weakref.WeakSet[SharedMemory] = weakref.WeakSet()
_absent: list[SharedMemory] = []


class SharedMemory(mmap.mmap):
    """Memory that stays shared with a process forked later, until it is shared no further."""

    is_shared = True

    def share_no_further(self) -> None:
        """Keep it from processes that are forked from now on."""
        if self.is_shared:
            self.madvise(mmap.MADV_DONTFORK)
            self.is_shared = False


def shared_memory(n_bytes: int) -> SharedMemory:
    """
    Return memory that stays shared with a process forked later; pages are allocated when written.

    Raises:
        MasterError: If the system does not give that much address space.
    """
    no_reserve = getattr(mmap, "MAP_NORESERVE", 0x4000)  # named since Python 3.13
    flags = mmap.MAP_SHARED | mmap.MAP_ANONYMOUS | no_reserve
    try:
        memory = SharedMemory(-1, n_bytes, flags=flags)
    except OSError as error:
        got = f"{error.strerror} for {n_bytes / 2**20:.0f} MB"
        raise MasterError(f"memory: the run has too little, got {got}, {MORE_MEMORY}") from None
    _alive.add(memory)
    return memory


def share_no_further() -> None:
    """
    Keep all shared memory from processes that are forked from now on.

    A copy of this process that an FMU makes and that comes back from the call ends at its next access,
    instead of stepping and writing rows beside this one.
    """
    for memory in _alive:
        memory.share_no_further()


def _keep_absent() -> None:
    """In a forked process: never free memory that it did not get, as something else may be at its address."""
    _absent.extend(memory for memory in _alive if not memory.is_shared)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_keep_absent)


_LEAST_ROOM = 2**20
_LIBRARIES = 384 * 2**20
_LIMIT_A_ROOM = 32
_SIDE = 256  # of matrices too large for the ways around a buffer


def room(wanted: int) -> int:
    """
    Return how many bytes of address space to take for what may need less than is wanted.

    Pages that are not used cost nothing, but a limit of the address space (`ulimit -v`) counts them: a small
    part of it at most.
    """
    limit = address_space()
    return wanted if math.isinf(limit) else min(wanted, max(_LEAST_ROOM, int(limit) // _LIMIT_A_ROOM))


def require_room_for_libraries() -> None:
    """
    See to it that what computes can be loaded: linear algebra ends a process where it has no room.

    Raises:
        MasterError: If a limit of the address space leaves too little.
    """
    if not math.isinf(address_space()):
        shared_memory(_LIBRARIES).close()


def take_room_of_linear_algebra() -> None:
    """
    Let linear algebra allocate its buffers now, where the address space is limited, and there is room.

    NumPy's and SciPy's each allocate one (32 MB) at the first product and keep it. Later, without room, one
    of them ends the process and the other tries for ever.

    Raises:
        MasterError: If a limit of the address space leaves too little.
    """
    if math.isinf(address_space()):
        return
    require_room_for_libraries()
    import numpy as np
    from scipy.linalg import blas

    large = np.ones((_SIDE, _SIDE))
    np.dot(large, large)
    blas.dgemm(1.0, large, large)


def address_space() -> float:
    """Return the limit of this process's address space [bytes]; infinite without one."""
    if sys.platform == "win32":
        return math.inf
    import resource

    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    return math.inf if limit == resource.RLIM_INFINITY else float(limit)


def raise_if_limited(ending: str) -> None:
    """
    Take a process that ended by itself for one without memory: linear algebra exits where it has none.

    Raises:
        MasterError: If the address space is limited; it says how the process ended.
    """
    limit = address_space()
    if not math.isinf(limit):
        raise MasterError(f"memory: {ending}, got an address space of {limit / 2**20:.0f} MB, {MORE_MEMORY}")


_SAID = (
    "cannot allocate memory",
    "cannot apply additional memory",
    "can't start new thread",
    "could not find/load shared object",
    "failed to map segment",
    "memoryerror",
    "out of memory",
    "unable to allocate",
)


def is_of_memory(error: BaseException) -> bool:
    """Whether an error that a library raises has its cause in too little memory."""
    seen: BaseException | None = error
    while seen is not None:
        if isinstance(seen, SystemError):  # the interpreter itself says no more than that something failed
            return not math.isinf(address_space())
        if isinstance(seen, MemoryError) or (isinstance(seen, OSError) and seen.errno == errno.ENOMEM):
            return True
        text = str(seen).lower()
        if isinstance(seen, ImportError | OSError | RuntimeError) and any(said in text for said in _SAID):
            return not math.isinf(address_space())
        seen = seen.__cause__ or seen.__context__
    return False
