"""Messages of FMI 2.0: a printf format with arguments, filled in without trusting either."""

from __future__ import annotations

import ctypes
import os
import platform
import re
import sys
from functools import lru_cache
from typing import Any

_CONVERSION = re.compile(
    r"%(?! +\w\w|[-+#0]* [-+ #0]*[^di\deEfFgGaA.*])"  # "50% of it": a space belongs to signed numbers
    r"(?P<flags>[-+ #0]*)(?P<width>\*|\d+)?(?:\.(?P<precision>\*|\d*))?"
    r"(?P<length>hh|h|ll|l|q|j|z|t|L|I64|I32)?(?P<kind>[diouxXcspneEfFgGaA%])"
)
_WIDEST = 1000
_BITS = {"hh": 8, "h": 16, None: 32, "I32": 32, "l": 8 * ctypes.sizeof(ctypes.c_long)}
_PAGE = 4096
_PIECE = 256
_ADDRESS_SPACE = 2**63

LONGEST = 4000  # bytes of a message that are read
CUT = f" ... (cut after {LONGEST} bytes)"


class UnreadableError(ValueError):
    """A format or an argument that is not what it says."""


class Arguments:
    """
    Variable arguments of a C function, from the address of its `va_list`.

    The layouts are those of the System V ABI for x86-64 (section 3.5.7), of the procedure call standard for
    AArch64 (appendix B), and, on Windows and macOS, a pointer to cells of 8 bytes.
    """

    def __init__(self, address: int) -> None:
        self._address = address
        machine = platform.machine().lower()
        if sys.platform == "win32" or (sys.platform == "darwin" and machine == "arm64"):
            self._next = self._in_memory
        elif machine in ("x86_64", "amd64"):
            self._next = self._of_x86_64
        elif machine in ("aarch64", "arm64"):
            self._next = self._of_aarch64
        else:
            raise UnreadableError(f"variable arguments on {machine}")

    def integer(self, bits: int, *, signed: bool) -> int:
        """Return the next argument as an integer."""
        value = ctypes.c_uint64.from_address(self._next(is_float=False)).value & ((1 << bits) - 1)
        return value - (1 << bits) if signed and value >> (bits - 1) else value

    def double(self) -> float:
        """Return the next argument as a double."""
        return ctypes.c_double.from_address(self._next(is_float=True)).value

    def _in_memory(self, *, is_float: bool) -> int:
        return self._advance(0, 8)

    def _of_x86_64(self, *, is_float: bool) -> int:
        offset = ctypes.c_uint32.from_address(self._address + (4 if is_float else 0))
        end, size = (176, 16) if is_float else (48, 8)
        if offset.value >= end:
            return self._advance(8, 8)
        place = self._pointer(16) + offset.value
        offset.value += size
        return place

    def _of_aarch64(self, *, is_float: bool) -> int:
        offset = ctypes.c_int32.from_address(self._address + (28 if is_float else 24))
        if offset.value >= 0:
            return self._advance(0, 8)
        place = self._pointer(16 if is_float else 8) + offset.value
        offset.value += 16 if is_float else 8
        return place

    def _pointer(self, at: int) -> int:
        return ctypes.c_uint64.from_address(self._address + at).value

    def _advance(self, at: int, n_bytes: int) -> int:
        """Return the address that a pointer in the list holds, and move it on."""
        pointer = ctypes.c_uint64.from_address(self._address + at)
        place = pointer.value
        pointer.value += n_bytes
        return place


def filled_in(text: str, arguments: int) -> str:
    """
    Fill arguments (the address of a `va_list`) into a printf format.

    A format that cannot be what the FMU meant, as it asks for text where there is none, is returned as it is.
    """
    if "%" not in text:
        return text
    try:
        given = Arguments(arguments)
        return _CONVERSION.sub(lambda match: _converted(match, given), text)
    except (UnreadableError, ValueError, OverflowError):
        return text


def _converted(match: re.Match[str], given: Arguments) -> str:
    kind, length, flags = match["kind"], match["length"], match["flags"]
    if kind == "%":
        return "%"
    width = _number(match["width"], given)
    if width is not None and width < 0:
        flags, width = flags + "-", -width
    precision = _number(match["precision"], given)
    form = f"%{flags}{'' if width is None else min(width, _WIDEST)}"
    if precision is not None and precision >= 0:
        form += f".{min(precision, _WIDEST)}"
    if kind in "eEfFgGaA":
        return _of_double(form, kind, length, given)
    if kind == "s":
        return form % _text(length, precision, given) if (form := form + "s") else ""
    if kind == "n":
        given.integer(64, signed=False)
        return ""
    if kind == "p":
        return f"{given.integer(64, signed=False):#x}"
    if kind == "c":
        return (form + "s") % chr(given.integer(8, signed=False))
    value = given.integer(_BITS.get(length, 64), signed=kind in "di")
    if kind == "o":
        return (form.replace("#", "") + "o") % value
    return (form + ("d" if kind == "u" else kind)) % value


def _of_double(form: str, kind: str, length: str | None, given: Arguments) -> str:
    if length == "L":
        raise UnreadableError("a long double")
    value = given.double()
    return value.hex() if kind in "aA" else (form + kind) % value


def _text(length: str | None, precision: int | None, given: Arguments) -> str:
    if length is not None:
        raise UnreadableError("text of wide characters")
    address = given.integer(64, signed=False)
    if address == 0:
        return "(null)"
    if precision is not None and 0 <= precision <= LONGEST:
        return text_at(address, precision)[0]
    text, is_whole = text_at(address)
    return text if is_whole else text + CUT


def _number(text: str | None, given: Arguments) -> int | None:
    """Return a width or a precision; `*` takes it from the arguments."""
    if text is None:
        return None
    return given.integer(32, signed=True) if text == "*" else int(text or 0)


def text_at(address: int, most: int = LONGEST) -> tuple[str, bool]:
    """
    Return the text at an address, at most so many bytes of it, and whether it is whole.

    Raises:
        UnreadableError: If the process has no memory there.
    """
    data = b""
    while len(data) < most and b"\0" not in data:
        place = address + len(data)
        data += _readable(place, min(most - len(data), _PIECE, _PAGE - place % _PAGE))
    text, end, _ = data.partition(b"\0")
    return text.decode("utf-8", errors="replace"), bool(end) or _ends(address + most)


def text_of(data: bytes | None) -> str:
    """Return a message that is no format, cut with a note."""
    text = (data or b"")[: LONGEST + 1].decode("utf-8", errors="replace")
    return text if len(data or b"") <= LONGEST else text[:LONGEST] + CUT


def _ends(address: int) -> bool:
    try:
        return _readable(address, 1) == b"\0"
    except UnreadableError:
        return True


def _readable(address: int, n: int) -> bytes:
    """Return n bytes within one page; the system says whether it can read them, copying into a pipe."""
    if not 0 < address < _ADDRESS_SPACE:
        raise UnreadableError(f"text at {address:#x}")
    if sys.platform == "win32":
        return ctypes.string_at(address, n)
    try:
        source, target = _pipe()
        written = _write()(target, address, n)
        if written > 0:
            return os.read(source, written)
    except OSError:  # an FMU closed what it did not open
        _pipe.cache_clear()
    raise UnreadableError(f"text at {address:#x}")


@lru_cache(maxsize=1)
def _pipe() -> tuple[int, int]:
    return os.pipe()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pipe.cache_clear)  # two processes would read each other's bytes


@lru_cache(maxsize=1)
def _write() -> Any:
    write = ctypes.CDLL(None).write
    write.argtypes = [ctypes.c_int, ctypes.c_void_p, ctypes.c_size_t]
    write.restype = ctypes.c_ssize_t
    return write
