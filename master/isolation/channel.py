"""The shared memory of an isolated FMU as Python sees it: texts of slow calls, and messages on their way."""

from __future__ import annotations

import ctypes
import json
import struct
from typing import Any

from master.process import position
from master.process.memory import room, shared_memory
from master.process.position import Position

from .layout import HEADER_BYTES

_LENGTH = struct.Struct("<Q")
_RING = struct.Struct("<QQQ")  # bytes written, bytes taken, messages lost
_TEXT_BYTES = 2**28  # of address space, where it is not limited
_RING_BYTES = 2**24
_LEAST_VALUES = 2**16
_BYTES_A_VARIABLE = 96
_LONGEST_MESSAGE = 2**16


class Channel:
    """
    Memory that a process and the process of an FMU share; `position` says which function the FMU is in.

    All that the FMU's process wrote is only text or numbers: nothing of it is loaded as an object.
    """

    def __init__(self, n_variables: int) -> None:
        self.values_bytes = _LEAST_VALUES + _BYTES_A_VARIABLE * n_variables
        self.sets_at = HEADER_BYTES
        self.gets_at = self.sets_at + self.values_bytes
        self._text_at = self.gets_at + self.values_bytes
        self._text_bytes = room(_TEXT_BYTES)
        self._ring_bytes = room(_RING_BYTES)
        self._ring_at = self._text_at + self._text_bytes
        self._memory = shared_memory(self._ring_at + _RING.size + self._ring_bytes)
        self._positions = shared_memory(position.N_BYTES)
        self.position = Position(self._positions)
        self.address = ctypes.addressof(ctypes.c_char.from_buffer(self._memory))

    def share_no_further(self) -> None:
        """Keep this memory from processes that are forked from now on."""
        for memory in (self._memory, self._positions):
            memory.share_no_further()

    def put(self, thing: Any) -> None:
        """Write a request or an answer of a slow call, as JSON."""
        data = json.dumps(thing).encode()
        if len(data) > self._text_bytes - _LENGTH.size:
            raise ValueError("more than an isolated FMU can be told in a call")
        first = self._text_at + _LENGTH.size
        self._memory[first : first + len(data)] = data
        self._memory[self._text_at : first] = _LENGTH.pack(len(data))

    def get(self) -> Any:
        """Read a request or an answer; ValueError if it is none."""
        first = self._text_at + _LENGTH.size
        [length] = _LENGTH.unpack(self._memory[self._text_at : first])
        if length > self._text_bytes - _LENGTH.size:
            raise ValueError("an answer without an end")
        try:
            return json.loads(self._memory[first : first + length])
        except RecursionError:
            raise ValueError("an answer of too many levels") from None

    def send(self, message: Any) -> None:
        """Put a message where the other process takes it; one for which there is no room is counted."""
        data = json.dumps(message).encode()
        written, taken, lost = self._ring()
        if len(data) > _LONGEST_MESSAGE or _LENGTH.size + len(data) > self._ring_bytes - (written - taken):
            self._put_ring(2, lost + 1)
            return
        for part in (_LENGTH.pack(len(data)), data):
            self._copy_in(written, part)
            written += len(part)
        self._put_ring(0, written)

    def received(self) -> tuple[list[Any], int]:
        """Take all messages that came, and the number of those that were lost."""
        written, taken, lost = self._ring()
        self._put_ring(2, 0)
        found = []
        try:
            while taken < written and written - taken <= self._ring_bytes:
                [length] = _LENGTH.unpack(self._copy_out(taken, _LENGTH.size))
                if length > _LONGEST_MESSAGE:
                    break
                found.append(json.loads(self._copy_out(taken + _LENGTH.size, length)))
                taken += _LENGTH.size + length
        except (ValueError, RecursionError):  # what the FMU itself wrote there
            lost += 1
        self._put_ring(1, written)
        return found, lost

    def _ring(self) -> tuple[int, int, int]:
        written, taken, lost = _RING.unpack(self._memory[self._ring_at : self._ring_at + _RING.size])
        return written, taken, lost

    def _put_ring(self, which: int, value: int) -> None:
        first = self._ring_at + 8 * which
        self._memory[first : first + 8] = _LENGTH.pack(value)

    def _copy_in(self, offset: int, data: bytes) -> None:
        first = offset % self._ring_bytes
        n = min(len(data), self._ring_bytes - first)
        base = self._ring_at + _RING.size
        self._memory[base + first : base + first + n] = data[:n]
        self._memory[base : base + len(data) - n] = data[n:]

    def _copy_out(self, offset: int, length: int) -> bytes:
        first = offset % self._ring_bytes
        n = min(length, self._ring_bytes - first)
        base = self._ring_at + _RING.size
        return self._memory[base + first : base + first + n] + self._memory[base : base + length - n]
