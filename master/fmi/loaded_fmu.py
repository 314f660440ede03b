"""What the FMUs of both FMI versions share as slaves: extraction, logging, statuses, the end."""

from __future__ import annotations

import ctypes
import logging
import math
from collections.abc import Callable, Mapping, Sequence
from itertools import groupby
from typing import Any

from master.errors import FmuError
from master.process import position
from master.process.child import do_last
from master.process.memory import is_of_memory
from master.process.surroundings import restore_working_folder, working_folder

from . import messages, unpacked
from .description import Description, Kind, Variable
from .messages import CHANGES_FLOAT_MODE
from .native.float_mode import restore_float_mode
from .slave import CInterface
from .status import Status, described, status_name
from .value_types import LONG, RANGES, TYPE_RANGES
from .values import shown

_logger = logging.getLogger("dockloop.fmu")


class FmuSlave:
    """Base of an FMU's instance; a subclass sets `_fmu` (FMPy's object) in `_instantiate`."""

    def __init__(self, name: str, description: Description) -> None:
        self.name, self.description = name, description
        self._ends_with_error = False
        self._is_initialised = False
        self._working_folder: str | None = None
        self._interface: CInterface | None = None
        self._is_harmless = description.keeps_float_mode  # our code changes no folder either
        self._folder = unpacked.acquire(description, unpacked.unpack)
        instantiate = "instantiate" if description.version == 2 else "instantiateCoSimulation"
        self._enter(instantiate)
        try:
            self._fmu: Any = self._instantiate()
        except Exception as error:  # FMPy and the loader raise bare exceptions
            unpacked.release(self._folder)
            if is_of_memory(error):
                raise
            raise self._not_instantiated(error) from None
        finally:
            self._leave()
        _raise_for_negative_statuses(self._fmu)

    def _not_instantiated(self, error: Exception) -> FmuError:
        answer = f"cannot be loaded: {str(error) or type(error).__name__}"
        if _has_no_instance(error):
            function = "instantiate" if self.description.version == 2 else "instantiateCoSimulation"
            answer = f"{self._full_name(function)} returned no instance"
        return FmuError(self.name, self._explained(answer), time=position.current().time())

    def interface(self) -> CInterface:
        if self._interface is None:
            self._interface = self._addresses()
        return self._interface

    def _addresses(self) -> CInterface:
        """Look up the library's functions."""
        raise NotImplementedError

    def _instantiate(self) -> Any:
        """Load the library and make an instance; return FMPy's object."""
        raise NotImplementedError

    def _create(self, fmu: Any) -> None:
        """Make an instance of the loaded library."""
        raise NotImplementedError

    def _setter(self, variable: Variable) -> Callable[..., Any]:
        """Give FMPy's setter for a variable's type."""
        raise NotImplementedError

    def _getter(self, variable: Variable) -> Callable[..., Any]:
        raise NotImplementedError

    def set(self, variables: Sequence[Variable], values: Sequence[float | str]) -> None:
        """Set variables in their order; neighbours of one type in one call."""
        taken = zip(variables, values, strict=True)
        for _, part in groupby(taken, lambda pair: (pair[0].kind, pair[0].value_type)):
            pairs = list(part)
            references = [variable.reference for variable, _ in pairs]
            numbers = [self._taken(variable, value) for variable, value in pairs]
            self._call(self._setter(pairs[0][0]), references, numbers)

    def _taken(self, variable: Variable, value: float | str) -> Any:
        """Turn a double, or a text, into what FMPy's setter takes; FmuError if the type does not hold it."""
        if variable.kind in (Kind.BOOLEAN, Kind.STRING):
            return bool(value) if variable.kind is Kind.BOOLEAN else str(value)
        number = value if isinstance(value, int) else float(value)
        ranges = TYPE_RANGES if isinstance(number, int) or variable.kind is Kind.REAL else RANGES
        least, largest = ranges.get(variable.value_type, (-math.inf, math.inf))
        is_free = variable.kind is Kind.REAL and not math.isfinite(number)
        if not (is_free or least <= number <= largest):
            problem = (
                f"value does not fit, got {shown(number)}, expected from {shown(least)} to {shown(largest)}"
            )
            raise FmuError(self.name, f"{variable.name}: {problem}")
        return number if variable.kind is Kind.REAL else round(number)

    def get(self, variables: Sequence[Variable]) -> list[float]:
        """Read variables; neighbours of one type in one call."""
        found: list[float] = []
        for _, part in groupby(variables, lambda variable: (variable.kind, variable.value_type)):
            alike = list(part)
            values = self._call(self._getter(alike[0]), [variable.reference for variable in alike])
            found += map(read_number, alike, values)
        return found

    def set_start_values(self, start: Mapping[str, float | str]) -> None:
        """Set configured parameters and start values."""
        self.set([self.description.by_name[key] for key in start], list(start.values()))

    def reset(self) -> None:
        messages.current().forget(self.name)
        self._is_initialised = False
        self._call(self._fmu.reset)

    def renew(self, *, failed: bool = False) -> None:
        """
        Become a new instance of the library, which stays loaded; after a fatal status nothing can be.

        An FMU of which a process may have one instance alone is reset.

        Raises:
            FmuError: If the FMU refuses.
        """
        if self.description.once_per_process:
            self.reset()
            return
        self._interface = None
        if self._is_initialised and not failed:
            self._end("terminate", self._fmu.terminate)
        free = getattr(self._fmu, f"fmi{self.description.version}FreeInstance")
        self._end("freeInstance", lambda: free(self._fmu.component))
        messages.current().forget(self.name)
        self._ends_with_error = False
        self._is_initialised = False
        self._enter("instantiate" if self.description.version == 2 else "instantiateCoSimulation")
        try:
            self._create(self._fmu)
        except Exception as error:  # FMPy raises bare exceptions
            raise self._not_instantiated(error) from None
        finally:
            self._leave()

    def exit_initialisation(self) -> None:
        self._call(self._fmu.exitInitializationMode)
        self._is_initialised = True

    def state_bytes(self) -> bytes:
        state = self._call(self._fmu.getFMUState)
        try:
            return bytes(self._call(self._fmu.serializeFMUState, state))
        finally:
            self._call(self._fmu.freeFMUState, state)

    def restore_bytes(self, data: bytes) -> None:
        state = self._call(self._fmu.deserializeFMUState, data)
        try:
            self._call(self._fmu.setFMUState, state)
        finally:
            self._call(self._fmu.freeFMUState, state)

    def last_message(self) -> str:
        return messages.current().of_call(self.name)

    def asked_for_end(self) -> bool:
        return False

    def process_fault(self) -> str:
        return ""

    def close(self, *, failed: bool, fatal: bool = False) -> None:
        if self._is_initialised and not failed and not fatal:
            fatal = self._end("terminate", self._fmu.terminate) == Status.FATAL
        if not fatal:
            self._end("freeInstance", self._free)
        unpacked.release(self._folder)

    def _end(self, function: str, call: Callable[[], Any]) -> int:
        """Make one of the last calls, which spoils no results any more; return its status."""
        self._enter(function)
        try:
            call()
        except Exception as error:  # FMPy: FMICallException with a status
            status: int = getattr(error, "status", Status.ERROR)
            answer = f"answered with {described(status)}" if hasattr(error, "status") else f"ended: {error}"
            self._note(status, messages.AT_THE_END, f"{self._full_name(function)} {answer}")
            return status
        finally:
            self._leave()
        return Status.OK

    def _free(self) -> None:
        """Free instance and library; the latter last of all, as a thread of the FMU may still run in it."""
        getattr(self._fmu, f"fmi{self.description.version}FreeInstance")(self._fmu.component)
        self._release_interpreter()
        do_last(self._fmu.freeLibrary)

    def _release_interpreter(self) -> None:
        """
        Let a library of PythonFMU or PythonFMU3 release its interpreter now.

        It stays loaded, and at the end of the process it would release it twice, first by the destructor of a
        static object and then by that of the library, which spoils the heap.
        """
        release = getattr(self._fmu.dll, "finalizePythonInterpreter", None)
        if release is not None:
            release()

    def _call(self, function: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
        position.current().check_stop()
        self._enter(function.__name__)
        try:
            return function(*arguments, **named)
        except Exception as error:  # FMPy: FMICallException with a status
            status = getattr(error, "status", None)
            time = position.current().time()
            if not isinstance(status, int):
                said = self._explained(f"{function.__name__}: {error}")
                raise FmuError(self.name, said, time=time) from None
            answer = f"{getattr(error, 'function', 'a call')} answered with {described(status)}"
            said = self._explained(answer)
            raise FmuError(self.name, said, time=time, status=status_name(status)) from None
        finally:
            self._leave()

    def _enter(self, function: str) -> None:
        """Note a call, by the name that FMPy's method has."""
        position.current().enter(self.name, self._full_name(function))
        if not self._is_harmless:
            self._working_folder = working_folder()

    def _full_name(self, function: str) -> str:
        return f"fmi{self.description.version}{function[0].upper()}{function[1:]}"

    def _leave(self) -> None:
        """Note the end of a call, and undo what it changed for the next one."""
        position.current().leave()
        if self._is_harmless:
            return
        restore_working_folder(self._working_folder)
        if restore_float_mode():
            self._note(Status.WARNING, "floating point", CHANGES_FLOAT_MODE)

    def _explained(self, answer: str) -> str:
        """What the FMU said of the call that failed, with how it answered."""
        said = self.last_message()
        return f"{said} ({answer})" if said else answer

    def _note(self, status: int, category: str, text: str) -> None:
        _logger.debug("%s (%s): %s", self.name, status_name(status), text)
        messages.current().note(self.name, status, category, text)
        self._ends_with_error = status >= Status.ERROR


def _has_no_instance(error: Exception) -> bool:
    """Whether FMPy says that an instance is missing, which it does in these words."""
    return "Failed to instantiate" in str(error)


def read_number(variable: Variable, value: Any) -> float:
    """Turn what FMPy read into a double; an integer of 64 bits stays one, with all of its digits."""
    return int(value) if variable.value_type in LONG and variable.kind is Kind.INTEGER else float(value)


def _raise_for_negative_statuses(fmu: Any) -> None:
    """Let an object of FMPy raise for statuses below 0 as it does for those above 1."""
    from fmpy.fmi1 import FMICallException

    call = fmu._call  # all functions of the FMU pass here; there is no public place that sees the status

    def checked(function: str, *arguments: Any) -> Any:
        result = call(function, *arguments)
        if isinstance(result, int) and result < 0:
            raise FMICallException(function=function, status=result)
        return result

    fmu._call = checked


def address(function: Any) -> int:
    """Address of a C function of a loaded library."""
    return ctypes.cast(function, ctypes.c_void_p).value or 0
