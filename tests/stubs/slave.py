"""
Slaves without FMU files: each made of one Python function, driven through C calls as an FMU is.

A law is a function (t, h, values) -> changed values; it is called with h = 0 during initialisation,
so that an output that hangs on an input follows it before the first step.
"""

from __future__ import annotations

import ctypes
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from master.fmi.description import DeclaredDelay, Description, Kind, Variable
from master.fmi.slave import CInterface
from master.fmi.units import Unit
from master.fmi.value_types import BOOLEAN, FLOAT32, FLOAT64, INT32, INT64, INT_BOOLEAN, UINT8

Law = Callable[[float, float, dict[str, float]], Mapping[str, float]]
OK, WARNING, DISCARD, ERROR, FATAL = range(5)

METRE = Unit("m", {"m": 1})
MILLIMETRE = Unit("mm", {"m": 1}, factor=1e-3)
KELVIN = Unit("K", {"K": 1})
CELSIUS = Unit("degC", {"K": 1}, offset=273.15)
NEWTON = Unit("N", {"kg": 1, "m": 1, "s": -2})

_C_TYPES = {
    FLOAT64: ctypes.c_double,
    FLOAT32: ctypes.c_float,
    UINT8: ctypes.c_uint8,
    INT32: ctypes.c_int32,
    INT_BOOLEAN: ctypes.c_int32,
    INT64: ctypes.c_int64,
    BOOLEAN: ctypes.c_bool,
}
_TAKEN: dict[Kind, Callable[[Any], Any]] = {
    Kind.REAL: float,
    Kind.INTEGER: round,
    Kind.BOOLEAN: bool,
    Kind.STRING: str,
}
_FMI_2 = {Kind.REAL: FLOAT64, Kind.INTEGER: INT32, Kind.BOOLEAN: INT_BOOLEAN, Kind.STRING: INT32}
_P, _N = ctypes.c_void_p, ctypes.c_size_t
_REFERENCES = ctypes.POINTER(ctypes.c_uint32)
EXCHANGE = {
    2: ctypes.CFUNCTYPE(ctypes.c_int, _P, _REFERENCES, _N, _P),
    3: ctypes.CFUNCTYPE(ctypes.c_int, _P, _REFERENCES, _N, _P, _N),
}
STEP = {
    2: ctypes.CFUNCTYPE(ctypes.c_int, _P, ctypes.c_double, ctypes.c_double, ctypes.c_int),
    3: ctypes.CFUNCTYPE(ctypes.c_int, _P, ctypes.c_double, ctypes.c_double, ctypes.c_bool, _P, _P, _P, _P),
}
_STATE_AT = ctypes.CFUNCTYPE(ctypes.c_int, _P, ctypes.POINTER(_P))
_STATE = ctypes.CFUNCTYPE(ctypes.c_int, _P, _P)


class Refusal(Exception):  # noqa: N818
    """Raised by a law that answers with a status instead of values."""

    def __init__(self, status: int, message: str = "") -> None:
        self.status, self.message = status, message
        super().__init__(message)


@dataclass(frozen=True)
class Block:
    """A kind of slave: its law and its variables."""

    law: Law
    variables: tuple[Variable, ...]
    feedthrough: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    influences: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    delays: tuple[DeclaredDelay, ...] = ()
    version: int = 2

    def description(self, name: str = "stub") -> Description:
        """Describe it as an FMU would."""
        return Description(
            path=Path(f"{name}.fmu"),
            fmi_version=f"{self.version}.0",
            model_name=name,
            model_identifier=name,
            token=name,
            variables=self.variables,
            delays=self.delays,
            can_get_and_set_state=True,
            feedthrough=self.feedthrough,
            influences=self.influences,
        )


def variables(*declared: tuple[str, str] | tuple[str, str, Mapping[str, Any]]) -> tuple[Variable, ...]:
    """Declare (name, causality[, more]) each; the value reference is the place in the list."""
    made = []
    for reference, (name, causality, *more) in enumerate(declared):
        given: dict[str, Any] = {"kind": Kind.REAL, "variability": "continuous", "start": "0"} | dict(*more)
        given.setdefault("value_type", _FMI_2[given["kind"]])
        made.append(Variable(name, reference, causality=causality, **given))
    return tuple(made)


class Stub:
    """A slave that keeps its variables by name and steps by its law."""

    def __init__(self, name: str, description: Description, law: Law) -> None:
        self.name, self.description, self._law = name, description, law
        self.values: dict[str, Any] = {
            v.name: v.start if v.kind is Kind.STRING else float(v.start or 0.0) for v in description.variables
        }
        self.events: list[str] = []
        self.states: dict[int, dict[str, Any]] = {}
        self._messages: list[str] = []
        self.wants_end = False
        self._time, self._stepping = 0.0, False
        self._c_functions = self._make_c_functions()

    def interface(self) -> CInterface:
        addresses = {key: _address(function) for key, function in self._c_functions.items()}
        pairs = {(v.kind, v.value_type) for v in self.description.variables if v.kind is not Kind.STRING}
        return CInterface(
            version=self.description.version,
            component=0,
            do_step=addresses["step"],
            get_state=addresses["get_state"],
            set_state=addresses["set_state"],
            free_state=addresses["free_state"],
            setters={pair: addresses["set", pair[1]] for pair in pairs},
            getters={pair: addresses["get", pair[1]] for pair in pairs},
        )

    def enter_initialisation(
        self, start: Mapping[str, float | str], t0: float, stop: float | None = None
    ) -> None:
        self.events.append("enter_initialisation")
        self.values |= start
        self._time = t0
        self.stop = stop

    def reset(self) -> None:
        self.events.append("reset")
        self.values = {
            v.name: v.start if v.kind is Kind.STRING else float(v.start or 0.0)
            for v in self.description.variables
        }
        self._stepping = False

    def exit_initialisation(self) -> None:
        self._settle()
        self._stepping = True
        self.events.append("exit_initialisation")

    def set(self, variables: Sequence[Variable], values: Sequence[float]) -> None:
        for variable, value in zip(variables, values, strict=True):
            self.values[variable.name] = _TAKEN[variable.kind](value)

    def get(self, variables: Sequence[Variable]) -> list[float]:
        self._settle()
        return [self.values[v.name] for v in variables]

    def state_bytes(self) -> bytes:
        return json.dumps(self.values).encode()

    def restore_bytes(self, data: bytes) -> None:
        self.values = json.loads(data)

    def last_message(self) -> str:
        return self._messages[-1] if self._messages else ""

    def asked_for_end(self) -> bool:
        return self.wants_end

    def process_fault(self):
        return ""

    def close(self, *, failed: bool, fatal: bool = False) -> None:
        self.events.append("abandoned" if fatal else "freed" if failed else "closed")

    def _settle(self) -> None:
        if not self._stepping:
            self.values |= self._law(self._time, 0.0, self.values)

    def _step(self, _: int, t: float, h: float, *__: int) -> int:
        try:
            self.values |= self._law(t, h, self.values)
        except Refusal as refusal:
            self._messages += [refusal.message] if refusal.message else []
            return refusal.status
        return OK

    def _get_state(self, _: int, place: Any) -> int:
        key = place[0] or 1 + max(self.states, default=0)
        self.states[key] = dict(self.values)
        place[0] = key
        return OK

    def _set_state(self, _: int, key: int) -> int:
        self.values = dict(self.states[key])
        return OK

    def _free_state(self, _: int, place: Any) -> int:
        self.states.pop(place[0], None)
        place[0] = None
        return OK

    def _make_c_functions(self) -> dict[Any, Any]:
        names = [v.name for v in self.description.variables]
        version = self.description.version

        def setter(kind: int) -> Any:
            def function(__: int, references: Any, n: int, values: int, *_: int) -> int:
                given = (_C_TYPES[kind] * n).from_address(values)
                for i in range(n):
                    self.values[names[references[i]]] = given[i]
                return OK

            return EXCHANGE[version](function)

        def getter(kind: int) -> Any:
            def function(__: int, references: Any, n: int, values: int, *_: int) -> int:
                wanted = (_C_TYPES[kind] * n).from_address(values)
                for i in range(n):
                    value = self.values[names[references[i]]]
                    wanted[i] = value if kind in (FLOAT64, FLOAT32) else int(value)
                return OK

            return EXCHANGE[version](function)

        made: dict[Any, Any] = {("set", kind): setter(kind) for kind in _C_TYPES}
        made |= {("get", kind): getter(kind) for kind in _C_TYPES}
        made |= {"get_state": _STATE_AT(self._get_state), "free_state": _STATE_AT(self._free_state)}
        return made | {"set_state": _STATE(self._set_state), "step": STEP[version](self._step)}


def _address(function: Any) -> int:
    return ctypes.cast(function, ctypes.c_void_p).value or 0
