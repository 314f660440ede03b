"""A universal ("fat") Mac library from one for each processor."""

from __future__ import annotations

import struct
from collections.abc import Sequence

_FAT_MAGIC = 0xCAFEBABE
_MACH_O_64 = 0xFEEDFACF
_ALIGNMENT = 14  # power of two; pages of 16 KiB


def join(slices: Sequence[bytes]) -> bytes:
    """
    Join 64-bit Mach-O files.

    Source: mach-o/fat.h; processor type and subtype are the second and third word of a slice.
    """
    page = 1 << _ALIGNMENT
    head = struct.pack(">II", _FAT_MAGIC, len(slices))
    body = b""
    for part in slices:
        magic, processor, subtype = struct.unpack_from("<III", part)
        assert magic == _MACH_O_64
        body += b"\0" * (-len(body) % page)
        head += struct.pack(">IIIII", processor, subtype, page + len(body), len(part), _ALIGNMENT)
        body += part
    return head.ljust(page, b"\0") + body
