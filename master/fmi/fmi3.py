"""An FMI 3.0 co-simulation FMU as a slave; the only file that knows this version's functions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from . import messages
from .description import Kind, Variable
from .event_mode import EventMode
from .loaded_fmu import FmuSlave, address, read_number
from .printf import text_of
from .signatures import keep_signatures
from .slave import CInterface
from .value_types import BOOLEAN, FLOAT32, FLOAT64, NAMES


def _kind(value_type: int) -> Kind:
    if value_type in (FLOAT64, FLOAT32):
        return Kind.REAL
    return Kind.BOOLEAN if value_type == BOOLEAN else Kind.INTEGER


class Fmi3Slave(FmuSlave):
    """One instance of an FMU 3.0; extracted and loaded on creation."""

    def _addresses(self) -> CInterface:
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
        """
        Set start values and enter initialisation mode.

        Structural parameters are set in configuration mode, before all others. An array whose other elements
        have no known start value is read in initialisation mode before it is set.
        """
        known = self.description.by_name
        structure = {key: value for key, value in start.items() if known[key].is_structural}
        if structure:
            self._call(self._fmu.enterConfigurationMode)
            self.set_start_values(structure)
            self._call(self._fmu.exitConfigurationMode)
        start = {key: value for key, value in start.items() if key not in structure}
        given = Counter(known[key].array for key in start)
        later = [key for key in start if self._must_be_read(known[key], given)]
        self.set_start_values({key: value for key, value in start.items() if key not in later})
        self._call(self._fmu.enterInitializationMode, startTime=t0, stopTime=stop)
        self._is_readable = True
        self.set_start_values({key: start[key] for key in later})

    def _must_be_read(self, variable: Variable, given: Mapping[str | None, int]) -> bool:
        array = variable.array
        return array in self.description.short_starts and given[array] < variable.size

    def reset(self) -> None:
        super().reset()
        self._started.clear()
        self._is_readable = False

    def set(self, variables: Sequence[Variable], values: Sequence[float | str]) -> None:
        """Set variables; an array is set as a whole, once for all of its elements that are given."""
        arrays: dict[str, dict[int, float | str]] = {}
        scalars: dict[int, float | str] = {}
        for i, (variable, value) in enumerate(zip(variables, values, strict=True)):
            if variable.array is None or variable.element is None:
                scalars[i] = value
            else:
                arrays.setdefault(variable.array, {})[variable.element] = value
        super().set([variables[i] for i in scalars], list(scalars.values()))
        for name, elements in arrays.items():
            self._set_array(self.description.arrays[name], elements)

    def _set_array(self, parts: Sequence[Variable], given: Mapping[int, float | str]) -> None:
        first = parts[0]
        values: list[float | str | None]
        if len(given) == len(parts):
            values = [given[i] for i in range(len(parts))]
        elif self._is_readable:
            values = [*self.get(parts)]
        else:
            values = self._started.get(first.reference) or [part.start_value for part in parts]
        for i, value in given.items():
            values[i] = value
        self._started[first.reference] = values
        taken = [self._taken(part, x or 0.0) for part, x in zip(parts, values, strict=True)]
        self._call(self._setter(first), [first.reference], taken)

    def get(self, variables: Sequence[Variable]) -> list[float]:
        """Read variables, each array once."""
        arrays: dict[int, Any] = {}
        scalars = [v for v in variables if v.element is None]
        read = iter(super().get(scalars))
        found = []
        for v in variables:
            if v.element is None:
                found.append(next(read))
                continue
            if v.reference not in arrays:
                arrays[v.reference] = self._call(self._getter(v), [v.reference], nValues=v.size)
            found.append(read_number(v, arrays[v.reference][v.element]))
        return found

    def _instantiate(self) -> Any:
        from fmpy.fmi3 import FMU3Slave

        keep_signatures(FMU3Slave)
        fmu = FMU3Slave(
            instanceName=self.name,
            guid=self.description.token,
            unzipDirectory=self._folder,
            modelIdentifier=self.description.model_identifier,
        )
        self._create(fmu)
        return fmu

    def _create(self, fmu: Any) -> None:
        self._started: dict[int, list[float | str | None]] = {}
        self._is_readable = False
        self._events: EventMode | None = None
        try:
            fmu.instantiate(loggingOn=True, logMessage=self._log)
        except Exception:  # FMPy raises bare exceptions
            if not self.description.has_event_mode:
                raise
            messages.current().forget(self.name)
            self._refuse_ticked_clocks()
            fmu.instantiate(loggingOn=True, logMessage=self._log, eventModeUsed=True, earlyReturnAllowed=True)
            self._events = EventMode(fmu)

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
