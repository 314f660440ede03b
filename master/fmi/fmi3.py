"""An FMI 3.0 co-simulation FMU as a slave; the only file that knows this version's functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from . import messages
from .description import Kind, Variable
from .event_mode import EventMode
from .loaded_fmu import FmuSlave, address
from .printf import text_of
from .slave import CInterface
from .value_types import BOOLEAN, FLOAT32, FLOAT64, NAMES
from .values import parse


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
            do_step=address(dll.fmi3DoStep) if self._events is None else self._events.do_step,
            get_state=address(dll.fmi3GetFMUState) if saves else 0,
            set_state=address(dll.fmi3SetFMUState) if saves else 0,
            free_state=address(dll.fmi3FreeFMUState) if saves else 0,
            setters={(_kind(t), t): address(getattr(dll, f"fmi3Set{name}")) for t, name in types},
            getters={(_kind(t), t): address(getattr(dll, f"fmi3Get{name}")) for t, name in types},
        )

    def enter_initialisation(
        self, start: Mapping[str, float | str], t0: float, stop: float | None = None
    ) -> None:
        self.set_start_values(start)
        self._call(self._fmu.enterInitializationMode, startTime=t0, stopTime=stop)

    def reset(self) -> None:
        super().reset()
        self._arrays.clear()

    def set(self, variables: Sequence[Variable], values: Sequence[float | str]) -> None:
        """Set variables; an array is set as a whole, once for all of its elements that are given."""
        for variable, value in zip(variables, values, strict=True):
            if variable.element is None:
                super().set([variable], [value])
            else:
                self._array(variable)[variable.element] = value
        for array in {v.reference: v for v in variables if v.element is not None}.values():
            given = [self._taken(array, x) for x in self._array(array)]
            self._call(self._setter(array), [array.reference], given)

    def get(self, variables: Sequence[Variable]) -> list[float]:
        found = []
        for v in variables:
            got = self._call(self._getter(v), [v.reference], nValues=v.size)
            found.append(float(got[v.element or 0]))
        return found

    def _array(self, variable: Variable) -> list[float | str]:
        """Last values that an array was set to."""
        if variable.reference not in self._arrays:
            parts = [v for v in self.description.variables if v.reference == variable.reference]
            self._arrays[variable.reference] = [parse(v, v.start or "0") for v in parts]
        return self._arrays[variable.reference]

    def _instantiate(self) -> Any:
        from fmpy.fmi3 import FMU3Slave

        self._arrays: dict[int, list[float | str]] = {}
        self._events: EventMode | None = None
        fmu = FMU3Slave(
            instanceName=self.name,
            guid=self.description.token,
            unzipDirectory=self._folder,
            modelIdentifier=self.description.model_identifier,
        )
        try:
            fmu.instantiate(loggingOn=True, logMessage=self._log)
        except Exception:  # FMPy raises bare exceptions
            if not self.description.has_event_mode:
                raise
            messages.current().forget(self.name)
            self._refuse_ticked_clocks()
            fmu.instantiate(loggingOn=True, logMessage=self._log, eventModeUsed=True, earlyReturnAllowed=True)
            self._events = EventMode(fmu)
        return fmu

    def _refuse_ticked_clocks(self) -> None:
        if self.description.ticked_clocks:
            names = ", ".join(self.description.ticked_clocks)
            raise ValueError(
                f"works in event mode only, with clocks that the master would have to tick: {names}"
            )

    def exit_initialisation(self) -> None:
        """Leave initialisation mode; an FMU in event mode settles its discrete states then."""
        super().exit_initialisation()
        if self._events is not None:
            self._call(self._events.update)

    def _setter(self, variable: Variable) -> Callable[..., Any]:
        name = "String" if variable.kind is Kind.STRING else NAMES[variable.value_type]
        setter: Callable[..., Any] = getattr(self._fmu, f"set{name}")
        return setter

    def _getter(self, variable: Variable) -> Callable[..., Any]:
        getter: Callable[..., Any] = getattr(self._fmu, f"get{NAMES[variable.value_type]}")
        return getter

    def _log(self, _: Any, status: int, category: bytes | None, message: bytes | None) -> None:
        self._note(status, text_of(category), text_of(message))
