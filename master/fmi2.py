"""An FMI 2.0 co-simulation FMU as a slave; the only file that knows this version's functions."""

from __future__ import annotations

import ctypes
import logging
import shutil
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from .calls import BOOL32, FLOAT64, INT32
from .description import Description, Kind, Variable
from .errors import FmuError
from .slave import CInterface

STATUS = ("ok", "warning", "discard", "error", "fatal", "pending")
_FATAL = 4
_logger = logging.getLogger("dockloop.fmu")


class Fmi2Slave:
    """One instance of an FMU; extracted and loaded on creation."""

    def __init__(self, name: str, description: Description, *, visible: bool = False) -> None:
        from fmpy import extract
        from fmpy.fmi2 import FMU2Slave

        self.name, self.description = name, description
        self._messages: list[str] = []
        self._folder = str(extract(str(description.path)))
        try:
            self._fmu = FMU2Slave(
                instanceName=name,
                guid=description.token,
                unzipDirectory=self._folder,
                modelIdentifier=description.model_identifier,
            )
            self._callbacks = self._make_callbacks()
            self._fmu.instantiate(visible=visible, callbacks=self._callbacks, loggingOn=True)
        except Exception as error:  # FMPy and the loader raise bare exceptions
            shutil.rmtree(self._folder, ignore_errors=True)
            raise FmuError(name, self._failure(f"cannot be loaded: {error}")) from None

    def interface(self) -> CInterface:
        dll = self._fmu.dll
        return CInterface(
            version=2,
            component=self._fmu.component,
            do_step=_address(dll.fmi2DoStep),
            setters={
                FLOAT64: _address(dll.fmi2SetReal),
                INT32: _address(dll.fmi2SetInteger),
                BOOL32: _address(dll.fmi2SetBoolean),
            },
            getters={
                FLOAT64: _address(dll.fmi2GetReal),
                INT32: _address(dll.fmi2GetInteger),
                BOOL32: _address(dll.fmi2GetBoolean),
            },
        )

    def enter_initialisation(self, start: Mapping[str, float | str], t0: float) -> None:
        for key, value in start.items():
            variable = self.description.by_name[key]
            if isinstance(value, str):
                self._call(self._fmu.setString, [variable.reference], [value])
            else:
                self.set([variable], [value])
        self._call(self._fmu.setupExperiment, startTime=t0)
        self._call(self._fmu.enterInitializationMode)

    def exit_initialisation(self) -> None:
        self._call(self._fmu.exitInitializationMode)

    def set(self, variables: Sequence[Variable], values: Sequence[float]) -> None:
        for kind, setter, convert in self._setters():
            chosen = [
                (v.reference, convert(x)) for v, x in zip(variables, values, strict=True) if v.kind is kind
            ]
            if chosen:
                self._call(setter, [r for r, _ in chosen], [x for _, x in chosen])

    def get(self, variables: Sequence[Variable]) -> list[float]:
        found: dict[int, float] = {}
        for kind, getter in self._getters():
            places = [i for i, v in enumerate(variables) if v.kind is kind]
            if places:
                values = self._call(getter, [variables[i].reference for i in places])
                found |= dict(zip(places, map(float, values), strict=True))
        return [found[i] for i in range(len(variables))]

    def last_message(self) -> str:
        return self._messages[-1] if self._messages else ""

    def close(self, *, failed: bool) -> None:
        if not failed:
            try:
                self._fmu.terminate()
                self._fmu.freeInstance()
            except Exception as error:  # an FMU that fails at its end has given its results already
                _logger.warning("%s: %s", self.name, error)
        shutil.rmtree(self._folder, ignore_errors=True)

    def _setters(self) -> list[tuple[Kind, Callable[..., Any], Callable[[float], Any]]]:
        return [
            (Kind.REAL, self._fmu.setReal, float),
            (Kind.INTEGER, self._fmu.setInteger, round),
            (Kind.BOOLEAN, self._fmu.setBoolean, bool),
        ]

    def _getters(self) -> list[tuple[Kind, Callable[..., Any]]]:
        return [
            (Kind.REAL, self._fmu.getReal),
            (Kind.INTEGER, self._fmu.getInteger),
            (Kind.BOOLEAN, self._fmu.getBoolean),
        ]

    def _call(self, function: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
        try:
            return function(*arguments, **named)
        except Exception as error:  # FMPy: FMICallException with a status
            status = getattr(error, "status", None)
            name = STATUS[status] if isinstance(status, int) and status < len(STATUS) else "error"
            raise FmuError(self.name, self._failure(str(error)), status=name) from None

    def _failure(self, text: str) -> str:
        said = next((m for m in self._messages if "py exception" not in m), "")
        return said or text

    def _make_callbacks(self) -> Any:
        from fmpy import calloc, free
        from fmpy.fmi2 import (
            fmi2CallbackAllocateMemoryTYPE,
            fmi2CallbackFreeMemoryTYPE,
            fmi2CallbackFunctions,
            fmi2CallbackLoggerTYPE,
        )

        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(self._log)
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        return callbacks

    def _log(self, _: Any, __: Any, status: int, ___: Any, message: bytes | None) -> None:
        text = (message or b"").decode("utf-8", errors="replace").strip()
        _logger.debug("%s (%s): %s", self.name, STATUS[status] if status < len(STATUS) else status, text)
        if status:
            self._messages.append(text)


def _address(function: Any) -> int:
    return ctypes.cast(function, ctypes.c_void_p).value or 0
