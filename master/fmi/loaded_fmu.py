"""What the FMUs of both FMI versions share as slaves: extraction, logging, statuses, the end."""

from __future__ import annotations

import ctypes
import logging
import tempfile
import zipfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from master.errors import FmuError

from . import unpacked
from .description import Description, Kind, Variable
from .value_types import RANGES

STATUS = ("ok", "warning", "discard", "error", "fatal", "pending")

_logger = logging.getLogger("dockloop.fmu")


class FmuSlave:
    """Base of an FMU's instance; a subclass sets `_fmu` (FMPy's object) in `_instantiate`."""

    def __init__(self, name: str, description: Description) -> None:
        self.name, self.description = name, description
        self._messages: list[str] = []
        self._ends_with_error = False
        self._is_initialised = False
        try:
            self._folder = unpacked.acquire(description, unpack)
        except (OSError, zipfile.BadZipFile) as error:
            raise FmuError(name, f"{description.path}: cannot be unpacked: {error}") from None
        try:
            self._fmu: Any = self._instantiate()
        except Exception as error:  # FMPy and the loader raise bare exceptions
            unpacked.release(self._folder)
            raise FmuError(name, self._failure(f"cannot be loaded: {error}")) from None

    def _instantiate(self) -> Any:
        raise NotImplementedError

    def _setter(self, variable: Variable) -> Callable[..., Any]:
        """Give FMPy's setter for a variable's type."""
        raise NotImplementedError

    def _getter(self, variable: Variable) -> Callable[..., Any]:
        raise NotImplementedError

    def set(self, variables: Sequence[Variable], values: Sequence[float | str]) -> None:
        for variable, value in zip(variables, values, strict=True):
            self._call(self._setter(variable), [variable.reference], [self._taken(variable, value)])

    def _taken(self, variable: Variable, value: float | str) -> Any:
        """Turn a double, or a text, into what FMPy's setter takes; FmuError if the type does not hold it."""
        if variable.kind is not Kind.INTEGER:
            return {Kind.REAL: float, Kind.BOOLEAN: bool, Kind.STRING: str}[variable.kind](value)
        least, largest = RANGES[variable.value_type]
        if not least <= float(value) <= largest:
            problem = f"value does not fit, got {value}, expected from {least:g} to {largest:g}"
            raise FmuError(self.name, f"{variable.name}: {problem}")
        return round(float(value))

    def get(self, variables: Sequence[Variable]) -> list[float]:
        found = []
        for variable in variables:
            [value] = self._call(self._getter(variable), [variable.reference])
            found.append(float(value))
        return found

    def set_start_values(self, start: Mapping[str, float | str]) -> None:
        """Set configured parameters and start values."""
        self.set([self.description.by_name[key] for key in start], list(start.values()))

    def exit_initialisation(self) -> None:
        self._call(self._fmu.exitInitializationMode)
        self._is_initialised = True

    def last_message(self) -> str:
        return self._messages[-1] if self._messages else ""

    def asked_for_end(self) -> bool:
        return False

    def close(self, *, failed: bool, fatal: bool = False) -> None:
        if not fatal:
            try:
                if self._is_initialised and not failed:
                    self._fmu.terminate()
                self._free()
            except Exception as error:  # an FMU that fails at its end has given its results already
                _logger.warning("%s: %s", self.name, error)
        unpacked.release(self._folder)

    def _free(self) -> None:
        self._fmu.freeInstance()

    def _call(self, function: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
        try:
            return function(*arguments, **named)
        except Exception as error:  # FMPy: FMICallException with a status
            status = getattr(error, "status", None)
            name = STATUS[status] if isinstance(status, int) and status < len(STATUS) else "error"
            raise FmuError(self.name, self._failure(str(error)), status=name) from None

    def _failure(self, text: str) -> str:
        """What the FMU said is wrong; PythonFMU's note on an exception only if there is nothing else."""
        said = next((m for m in reversed(self._messages) if "py exception" not in m), "")
        return said or text

    def _note(self, status: int, message: bytes | None) -> None:
        text = (message or b"").decode("utf-8", errors="replace").strip()
        _logger.debug("%s (%s): %s", self.name, STATUS[status] if status < len(STATUS) else status, text)
        if status:
            self._messages.append(text)
        self._ends_with_error = status >= STATUS.index("error")


def unpack(path: Path) -> str:
    """Unpack what an FMU needs to run here into a new folder: its resources and this platform's binary."""
    from fmpy import platform, platform_tuple

    folder = tempfile.mkdtemp(prefix="dockloop-")
    wanted = ("modelDescription.xml", "resources/", f"binaries/{platform}/", f"binaries/{platform_tuple}/")
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder, [m for m in archive.namelist() if m.startswith(wanted)])
    return folder


def address(function: Any) -> int:
    """Address of a C function of a loaded library."""
    return ctypes.cast(function, ctypes.c_void_p).value or 0
