"""An FMI 2.0 co-simulation FMU as a slave; the only file that knows this version's functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from . import logger
from .description import Kind, Variable
from .loaded_fmu import FmuSlave, address
from .signatures import keep_signatures
from .slave import CInterface
from .value_types import FLOAT64, INT32, INT_BOOLEAN

_NAMES = {Kind.REAL: "Real", Kind.INTEGER: "Integer", Kind.BOOLEAN: "Boolean", Kind.STRING: "String"}
_TERMINATED = 3  # fmi2Terminated of fmi2StatusKind
_EXCHANGED = ((Kind.REAL, FLOAT64), (Kind.INTEGER, INT32), (Kind.BOOLEAN, INT_BOOLEAN))


class Fmi2Slave(FmuSlave):
    """One instance of an FMU 2.0; extracted and loaded on creation."""

    def _addresses(self) -> CInterface:
        dll = self._fmu.dll
        saves = self.description.can_get_and_set_state
        return CInterface(
            version=2,
            component=self._fmu.component,
            do_step=address(dll.fmi2DoStep),
            get_state=address(dll.fmi2GetFMUstate) if saves else 0,
            set_state=address(dll.fmi2SetFMUstate) if saves else 0,
            free_state=address(dll.fmi2FreeFMUstate) if saves else 0,
            setters={pair: address(getattr(dll, f"fmi2Set{_NAMES[pair[0]]}")) for pair in _EXCHANGED},
            getters={pair: address(getattr(dll, f"fmi2Get{_NAMES[pair[0]]}")) for pair in _EXCHANGED},
        )

    def enter_initialisation(
        self, start: Mapping[str, float | str], t0: float, stop: float | None = None
    ) -> None:
        self.set_start_values(start)
        self._call(self._fmu.setupExperiment, startTime=t0, stopTime=stop)
        self._call(self._fmu.enterInitializationMode)

    def asked_for_end(self) -> bool:
        if self._ends_with_error:  # PythonFMU calls every step that it discards the end of the simulation
            return False
        try:
            return bool(self._fmu.getBooleanStatus(_TERMINATED))
        except Exception:  # FMPy: the FMU does not answer the question
            return False

    def _instantiate(self) -> Any:
        from fmpy.fmi2 import FMU2Slave

        keep_signatures(FMU2Slave)
        fmu = FMU2Slave(
            instanceName=self.name,
            guid=self.description.token,
            unzipDirectory=self._folder,
            modelIdentifier=self.description.model_identifier,
        )
        self._callbacks = self._make_callbacks()
        self._create(fmu)
        return fmu

    def _create(self, fmu: Any) -> None:
        fmu.instantiate(callbacks=self._callbacks, loggingOn=True)

    def _free(self) -> None:
        super()._free()
        logger.remove(self._environment)

    def _setter(self, variable: Variable) -> Callable[..., Any]:
        setter: Callable[..., Any] = getattr(self._fmu, f"set{_NAMES[variable.kind]}")
        return setter

    def _getter(self, variable: Variable) -> Callable[..., Any]:
        getter: Callable[..., Any] = getattr(self._fmu, f"get{_NAMES[variable.kind]}")
        return getter

    def _make_callbacks(self) -> Any:
        from fmpy import calloc, free
        from fmpy.fmi2 import (
            fmi2CallbackAllocateMemoryTYPE,
            fmi2CallbackFreeMemoryTYPE,
            fmi2CallbackFunctions,
            fmi2CallbackLoggerTYPE,
        )

        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(logger.address())
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        self._environment = logger.add(self._note)
        callbacks.componentEnvironment = self._environment
        return callbacks
