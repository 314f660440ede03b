"""Objects handed from one process to another through memory that they share."""

from __future__ import annotations

import pickle
import struct
from typing import Any

from master.errors import MasterError

from .memory import MORE_MEMORY, room, shared_memory

_LENGTH = struct.Struct("<Q")
_MOST_BYTES = 2**28  # of address space, where it is not limited


class Mailbox:
    """Holds the last object that was put; half of one, left by a process that ended, is none."""

    def __init__(self) -> None:
        self.most_bytes = room(_MOST_BYTES)
        self._memory = shared_memory(self.most_bytes)

    def put(self, thing: Any) -> None:
        """Put an object that can be pickled; MasterError if it is too large."""
        data = pickle.dumps(thing)
        first = _LENGTH.size
        if first + len(data) > self.most_bytes:
            got = f"{len(data) / 2**20:.0f} MB of {self.most_bytes / 2**20:.0f} MB"
            raise MasterError(f"memory: a result needs too much, got {got}, {MORE_MEMORY}")
        self._memory[:first] = _LENGTH.pack(0)
        self._memory[first : first + len(data)] = data
        self._memory[:first] = _LENGTH.pack(len(data))

    def get(self) -> Any:
        """Return the object, None if there is none."""
        first = _LENGTH.size
        [length] = _LENGTH.unpack(self._memory[:first])
        return pickle.loads(self._memory[first : first + length]) if length else None

    def is_empty(self) -> bool:
        """Whether there is none."""
        return not any(self._memory[: _LENGTH.size])

    def take(self) -> Any:
        """Return the object and remove it, None if there is none."""
        thing = self.get()
        if thing is not None:
            self._memory[: _LENGTH.size] = _LENGTH.pack(0)
        return thing
