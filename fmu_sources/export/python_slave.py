"""The shell between a model's instance and PythonFMU: the only file here that imports pythonfmu."""

from __future__ import annotations

from typing import Any, ClassVar

from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

from ..framework.instance import Instance, ModelError
from ..framework.model import Model

_MODE = ("_initialising", "_fresh", "_start_time")


class ModelSlave(Fmi2Slave):  # type: ignore[misc]
    """FMI 2.0 slave of one model; a subclass in the FMU names the model."""

    model: ClassVar[Model]

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.instance = Instance(self.model)
        self._initialising = False
        self._fresh = False
        self._start_time = 0.0

    def setup_experiment(self, start_time: float, *_: Any) -> None:
        self._start_time = start_time

    def enter_initialization_mode(self) -> None:
        self._initialising = True
        self._fresh = False
        self._refuse_bad_values()

    def exit_initialization_mode(self) -> None:
        self._refresh()
        self._initialising = False

    def do_step(self, current_time: float, step_size: float) -> bool:
        try:
            if not self._fresh:
                self.instance.check()
                self._fresh = True
            self.instance.step(current_time, step_size)
        except ModelError as error:
            self.log(str(error), Fmi2Status.error)
            return (
                False  # discards the step; an exception would be fatal, and PythonFMU crash in what follows
            )
        return True

    def get_real(self, vrs: list[int]) -> list[float]:
        self._refresh()
        values = self.instance.values
        return [float(values[vr]) for vr in vrs]

    def get_integer(self, vrs: list[int]) -> list[int]:
        self._refresh()
        return [int(self.instance.values[vr]) for vr in vrs]

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        self._refresh()
        return [bool(self.instance.values[vr]) for vr in vrs]

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        own = self.instance.values
        if self._initialising or min(vrs, default=0) < len(self.model.parameters):
            self._fresh = False
        for vr, value in zip(vrs, values, strict=True):
            own[vr] = value

    set_integer = set_real
    set_boolean = set_real

    def _refresh(self) -> None:
        """Bring calculated start values up to date while inputs may still change."""
        if self._initialising and not self._fresh:
            self._refuse_bad_values()
            self.instance.initialise(self._start_time)
            self._fresh = True

    def _refuse_bad_values(self) -> None:
        """Raise, which PythonFMU turns into a fatal status, after the message has gone to the logger."""
        problems = self.instance.problems()
        if problems:
            message = "; ".join(problems)
            self.log(message, Fmi2Status.error)
            raise ModelError(message)

    def _get_fmu_state(self) -> dict[str, Any]:
        own = self.instance
        return {name: getattr(self, name) for name in _MODE} | {
            "values": list(own.values),
            "previous_inputs": list(own.previous_inputs),
            "time": own.time,
        }

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        for name in _MODE:
            setattr(self, name, state[name])
        self.instance.values = list(state["values"])
        self.instance.previous_inputs = list(state["previous_inputs"])
        self.instance.time = state["time"]
