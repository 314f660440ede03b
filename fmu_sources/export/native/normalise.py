"""Binaries without the time at which they were linked."""

from __future__ import annotations

import struct

_DIRECTORY_OF_EXPORTS = 0
_OPTIONAL_HEADER = 24


def normalise(binary: bytes) -> bytes:
    """Put zero for the time stamps of a Windows library; return any other binary as it is."""
    if not binary.startswith(b"MZ"):
        return binary
    changed = bytearray(binary)
    (pe,) = struct.unpack_from("<I", changed, 0x3C)
    assert changed[pe : pe + 4] == b"PE\0\0"
    struct.pack_into("<I", changed, pe + 8, 0)
    struct.pack_into("<I", changed, pe + _OPTIONAL_HEADER + 64, 0)  # checksum, unused for a library
    return bytes(changed)
