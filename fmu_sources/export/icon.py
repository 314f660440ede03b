"""The icon of an FMU, drawn from its model's name: a PNG of a few hundred bytes, the same at every build."""

from __future__ import annotations

import hashlib
import struct
import zlib

SIZE = 64
_CELLS = 5


def icon_png(name: str) -> bytes:
    """Draw a symmetric pattern of blocks whose shape and colour come from the name."""
    digest = hashlib.sha256(name.encode()).digest()
    colour = bytes(60 + byte % 130 for byte in digest[:3])
    filled = [
        [digest[3 + row * 3 + min(c, _CELLS - 1 - c)] % 2 for c in range(_CELLS)] for row in range(_CELLS)
    ]
    rows = b"".join(_row(filled, y, colour) for y in range(SIZE))
    header = struct.pack(">IIBBBBB", SIZE, SIZE, 8, 2, 0, 0, 0)
    parts = (_chunk(b"IHDR", header), _chunk(b"IDAT", zlib.compress(rows, 9)), _chunk(b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def _row(filled: list[list[int]], y: int, colour: bytes) -> bytes:
    cell = (SIZE - 4) // _CELLS
    pixels = b""
    for x in range(SIZE):
        row, column = (y - 2) // cell, (x - 2) // cell
        inside = 0 <= row < _CELLS and 0 <= column < _CELLS
        pixels += colour if inside and filled[row][column] else b"\xff\xff\xff"
    return b"\x00" + pixels


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
