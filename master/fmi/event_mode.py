"""
Event mode of FMI 3.0, for an FMU that does not work without it; all others handle their events themselves.

Between two steps such an FMU stands in event mode, where all of its inputs may be set. A step begins with
its discrete states, goes through step mode, and stops on the way where the FMU returns for an event.
"""

from __future__ import annotations

import ctypes
from typing import Any

from .loaded_fmu import address

_P, _D = ctypes.c_void_p, ctypes.c_double
_FLAG, _TIME = ctypes.POINTER(ctypes.c_bool), ctypes.POINTER(ctypes.c_double)
_STEP = ctypes.CFUNCTYPE(ctypes.c_int, _P, _D, _D, ctypes.c_bool, _FLAG, _FLAG, _FLAG, _TIME)
_MOST_UPDATES = 1000
_ERROR = 3


class EventMode:
    """A function in the form of fmi3DoStep that leads an FMU (FMPy's object) through its events."""

    def __init__(self, fmu: Any) -> None:
        self._fmu = fmu
        self._function = _STEP(self._step)
        self.do_step = address(self._function)

    def update(self) -> bool:
        """Update the discrete states until they stand; give whether the FMU ends the simulation."""
        for _ in range(_MOST_UPDATES):
            again, end, *_ = self._fmu.updateDiscreteStates()
            if end or not again:
                return bool(end)
        raise RuntimeError(f"discrete states do not settle in {_MOST_UPDATES} updates")

    def _step(self, _: int, t: float, h: float, __: bool, *answers: Any) -> int:
        events, end, early, last = answers
        events[0] = early[0] = False
        try:
            end[0], last[0] = self._go(t, t + h)
        except Exception as error:  # FMPy: FMICallException with a status
            status = getattr(error, "status", _ERROR)
            return status if isinstance(status, int) else _ERROR
        return 0

    def _go(self, t: float, stop: float) -> tuple[bool, float]:
        """Step from t to `stop` [s] through all events; give whether to end, and the time reached."""
        reached = t
        tolerance = 1e-9 * (stop - t) + 4e-16 * abs(stop)  # a large time rounds coarsely
        while True:
            if self.update():
                return True, reached
            if stop - reached <= tolerance:
                return False, stop
            self._fmu.enterStepMode()
            _, end, _, last = self._fmu.doStep(reached, stop - reached)
            if not last > reached:
                raise RuntimeError("a step does not get on")
            reached = last
            self._fmu.enterEventMode()
            if end:
                return True, reached
