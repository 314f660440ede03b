"""An FMI 3.0 co-simulation FMU as a slave; the only file that knows this version's functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from .description import Kind, Variable
from .fmu import WHOLE, FmuSlave, address, identity
from .slave import CInterface
from .value_types import BOOLEAN, FLOAT32, FLOAT64, NAMES


def _kind(value_type: int) -> Kind:
    if value_type in (FLOAT64, FLOAT32):
        return Kind.REAL
    return Kind.BOOLEAN if value_type == BOOLEAN else Kind.INTEGER


class Fmi3Slave(FmuSlave):
    """One instance of an FMU 3.0; extracted and loaded on creation."""

    def interface(self) -> CInterface:
        dll = self._fmu.dll
        saves = self.description.can_get_and_set_state
        types = list(enumerate(NAMES))
        return CInterface(
            version=3,
            component=self._fmu.component,
            do_step=address(dll.fmi3DoStep),
            get_state=address(dll.fmi3GetFMUState) if saves else 0,
            set_state=address(dll.fmi3SetFMUState) if saves else 0,
            free_state=address(dll.fmi3FreeFMUState) if saves else 0,
            setters={(_kind(t), t): address(getattr(dll, f"fmi3Set{name}")) for t, name in types},
            getters={(_kind(t), t): address(getattr(dll, f"fmi3Get{name}")) for t, name in types},
        )

    def enter_initialisation(self, start: Mapping[str, float | str], t0: float) -> None:
        self.set_start_values(start)
        self._call(self._fmu.enterInitializationMode, startTime=t0)

    def _instantiate(self) -> Any:
        from fmpy.fmi3 import FMU3Slave

        fmu = FMU3Slave(
            instanceName=self.name,
            guid=self.description.token,
            unzipDirectory=self._folder,
            modelIdentifier=self.description.model_identifier,
        )
        fmu.instantiate(loggingOn=True, logMessage=self._log)
        return fmu

    def _setter(self, variable: Variable) -> tuple[Callable[..., Any], Callable[[Any], Any]]:
        name = "String" if variable.kind is Kind.STRING else NAMES[variable.value_type]
        return getattr(self._fmu, f"set{name}"), WHOLE.get(variable.kind, identity)

    def _getter(self, variable: Variable) -> Callable[..., Any]:
        getter: Callable[..., Any] = getattr(self._fmu, f"get{NAMES[variable.value_type]}")
        return getter

    def _log(self, _: Any, status: int, __: Any, message: bytes | None) -> None:
        self._note(status, message)
