"""A native binary through ctypes: the few FMI calls that the tests need, for FMI 2.0 and FMI 3.0."""

from __future__ import annotations

import ctypes
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_int32, c_int64, c_size_t, c_uint, c_void_p
from pathlib import Path
from typing import Any, ClassVar

from fmu_sources.framework.model import Model
from fmu_sources.framework.variables import Variable

GUID = "{00000000-0000-0000-0000-000000000000}"

_Logger2 = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)
_Logger3 = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)


class _Callbacks(ctypes.Structure):
    _fields_ = (
        ("logger", _Logger2),
        ("allocate", c_void_p),
        ("free", c_void_p),
        ("finished", c_void_p),
        ("environment", c_void_p),
    )


def kind(v: Variable) -> str:
    """Type of a variable: real, integer, enumeration or boolean."""
    if v.items is not None:
        return "enumeration"
    return "boolean" if v.boolean else "integer" if v.integer else "real"


class Fmu:
    """One instance of a native binary; statuses are returned, messages collected."""

    version: str
    functions: ClassVar[dict[str, str]]
    types: ClassVar[dict[str, Any]]

    def __init__(self, path: Path, model: Model, guid: str = GUID, name: str = "fmu") -> None:
        self.model, self.path = model, path
        self.library = ctypes.CDLL(str(path))
        self.messages: list[str] = []
        self.variables = list(model.all_variables)
        self.index = {v.name: i for i, v in enumerate(self.variables)}
        self.component = self._instantiate(guid.encode(), name.encode())

    def _instantiate(self, guid: bytes, name: bytes) -> c_void_p:
        raise NotImplementedError

    def call(self, function: str, *arguments: object) -> int:
        return int(getattr(self.library, function)(self.component, *arguments))

    def set_references(self, references: list[int], values: list[float]) -> int:
        """Set variables of one type."""
        name = kind(self.variables[references[0]])
        return self.transfer("Set", name, references, (self.types[name] * len(values))(*values))

    def get_references(self, references: list[int]) -> list[float]:
        """Get variables of one type; the call must succeed."""
        name = kind(self.variables[references[0]])
        array = (self.types[name] * len(references))()
        assert self.transfer("Get", name, references, array) == 0, self.messages
        return list(array)

    def transfer(self, verb: str, name: str, references: list[int], array: object) -> int:
        raise NotImplementedError

    def set(self, **values: float) -> int:
        return max(self.set_references([self.index[name]], [value]) for name, value in values.items())

    def get(self, name: str) -> float:
        return self.get_references([self.index[name]])[0]

    def status_of_get(self, name: str) -> int:
        array = (self.types[kind(self.variables[self.index[name]])] * 1)()
        return self.transfer("Get", kind(self.variables[self.index[name]]), [self.index[name]], array)

    def initialise(self, t: float = 0.0) -> int:
        return self.enter(t) or self.exit()

    def enter(self, t: float = 0.0) -> int:
        raise NotImplementedError

    def exit(self) -> int:
        return self.call(f"fmi{self.version}ExitInitializationMode")

    def terminate(self) -> int:
        return self.call(f"fmi{self.version}Terminate")

    def reset(self) -> int:
        return self.call(f"fmi{self.version}Reset")

    def step(self, t: float, h: float) -> int:
        raise NotImplementedError

    def free(self) -> None:
        function = getattr(self.library, f"fmi{self.version}FreeInstance")
        function.restype = None
        function(self.component)

    def save(self) -> c_void_p:
        state = c_void_p()
        assert self.call(self._state("Get"), byref(state)) == 0
        return state

    def restore(self, state: c_void_p) -> int:
        return self.call(self._state("Set"), state)

    def serialise(self, state: c_void_p) -> bytes:
        size = c_size_t()
        assert self.call(f"fmi{self.version}Serialized{self._word}Size", state, byref(size)) == 0
        array = (ctypes.c_char * size.value)()
        assert self.call(f"fmi{self.version}Serialize{self._word}", state, array, size) == 0
        return bytes(array)

    def deserialise(self, content: bytes) -> tuple[int, c_void_p]:
        state = c_void_p()
        name = "DeSerialize" if self.version == "2" else "Deserialize"
        function = f"fmi{self.version}{name}{self._word}"
        return self.call(function, content, c_size_t(len(content)), byref(state)), state

    def _state(self, verb: str) -> str:
        return f"fmi{self.version}{verb}{self._word}"

    @property
    def _word(self) -> str:
        return "FMUstate" if self.version == "2" else "FMUState"

    def derivative(self, unknown: str, known: str) -> float:
        """Directional derivative of one variable along another one."""
        rows, columns = (c_uint * 1)(self.index[unknown]), (c_uint * 1)(self.index[known])
        seed, result, one = (c_double * 1)(1.0), (c_double * 1)(), c_size_t(1)
        arrays = (rows, one, columns, one, seed, result)
        if self.version == "3":
            arrays = (rows, one, columns, one, seed, one, result, one)
        assert self.call(f"fmi{self.version}GetDirectionalDerivative", *arrays) == 0, self.messages
        return float(result[0])


class Fmu2(Fmu):
    """FMI 2.0."""

    version = "2"
    functions: ClassVar = {
        "real": "Real",
        "integer": "Integer",
        "enumeration": "Integer",
        "boolean": "Boolean",
    }
    types: ClassVar = {"real": c_double, "integer": c_int, "enumeration": c_int, "boolean": c_int}

    def _instantiate(self, guid: bytes, name: bytes) -> c_void_p:
        self.logger = _Logger2(lambda _e, _n, _s, _c, text: self.messages.append(text.decode()))
        self.callbacks = _Callbacks(self.logger, None, None, None, None)
        create = self.library.fmi2Instantiate
        create.restype = c_void_p
        return c_void_p(create(name, 1, guid, None, byref(self.callbacks), 0, 0))

    def transfer(self, verb: str, name: str, references: list[int], array: object) -> int:
        vr = (c_uint * len(references))(*references)
        return self.call(f"fmi2{verb}{self.functions[name]}", vr, c_size_t(len(references)), array)

    def enter(self, t: float = 0.0) -> int:
        zero = c_double(0.0)
        status = self.call("fmi2SetupExperiment", 0, zero, c_double(t), 0, zero)
        return status or self.call("fmi2EnterInitializationMode")

    def step(self, t: float, h: float) -> int:
        return self.call("fmi2DoStep", c_double(t), c_double(h), 1)


class Fmu3(Fmu):
    """FMI 3.0."""

    version = "3"
    functions: ClassVar = {
        "real": "Float64",
        "integer": "Int32",
        "enumeration": "Int64",
        "boolean": "Boolean",
    }
    types: ClassVar = {"real": c_double, "integer": c_int32, "enumeration": c_int64, "boolean": c_bool}

    def _instantiate(self, guid: bytes, name: bytes) -> c_void_p:
        self.logger = _Logger3(lambda _e, _s, _c, text: self.messages.append(text.decode()))
        create = self.library.fmi3InstantiateCoSimulation
        create.restype = c_void_p
        off = c_bool(False)
        nothing = (None, c_size_t(0), None)
        return c_void_p(create(name, guid, None, off, off, off, off, *nothing, self.logger, None))

    def transfer(self, verb: str, name: str, references: list[int], array: object) -> int:
        vr = (c_uint * len(references))(*references)
        count = c_size_t(len(references))
        return self.call(f"fmi3{verb}{self.functions[name]}", vr, count, array, count)

    def enter(self, t: float = 0.0) -> int:
        off, zero = c_bool(False), c_double(0.0)
        return self.call("fmi3EnterInitializationMode", off, zero, c_double(t), off, zero)

    def step(self, t: float, h: float) -> int:
        flags = [c_bool() for _ in range(3)]
        last = c_double()
        references = [byref(flag) for flag in flags]
        return self.call("fmi3DoStep", c_double(t), c_double(h), c_bool(True), *references, byref(last))


VERSIONS = (Fmu2, Fmu3)
