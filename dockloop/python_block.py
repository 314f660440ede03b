"""
A subsystem as a Python function, in a system next to FMUs.

The stepping loop calls it as it calls an FMU, through C functions: about 5 us a step, not below one.
"""

from __future__ import annotations

import copy
import ctypes
import inspect
import math
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from master.errors import ConfigError, FmuError, Problem
from master.fmi.description import Description, Kind, Variable
from master.fmi.slave import CInterface
from master.fmi.status import Status
from master.fmi.unit_names import unit
from master.fmi.value_types import FLOAT64

Step = Callable[..., Mapping[str, float]]
Declared = Mapping[str, Any] | Iterable[str]

_REAL = (Kind.REAL, FLOAT64)
_POINTER = ctypes.c_void_p
_REFERENCES = ctypes.POINTER(ctypes.c_uint32)
_EXCHANGE = ctypes.CFUNCTYPE(ctypes.c_int, _POINTER, _REFERENCES, ctypes.c_size_t, _POINTER)
_DO_STEP = ctypes.CFUNCTYPE(ctypes.c_int, _POINTER, ctypes.c_double, ctypes.c_double, ctypes.c_int)
_STATE_AT = ctypes.CFUNCTYPE(ctypes.c_int, _POINTER, ctypes.POINTER(_POINTER))
_STATE = ctypes.CFUNCTYPE(ctypes.c_int, _POINTER, _POINTER)


@dataclass(frozen=True)
class Block:
    """
    A Python function as a subsystem; made by `block`.

    Attributes:
        step: The function.
        variables: Declarations of inputs, parameters and outputs.
        state: What each instance starts with, copied for each run.
    """

    step: Step
    variables: tuple[Variable, ...]
    state: Any = None

    def description(self, name: str) -> Description:
        """Describe it as an FMU would be, under a name."""
        inputs = tuple(v.name for v in self.variables if v.causality == "input")
        outputs = [v.name for v in self.variables if v.causality == "output"]
        return Description(
            path=Path(f"{name} (Python block)"),
            fmi_version="2.0",
            model_name=name,
            model_identifier=name,
            token=name,
            variables=self.variables,
            can_get_and_set_state=True,
            feedthrough=dict.fromkeys(outputs, inputs),
            influences=dict.fromkeys(outputs, inputs),
        )

    def __repr__(self) -> str:
        names = {
            c: ", ".join(v.name for v in self.variables if v.causality == c) for c in ("input", "output")
        }
        return f"<Block {getattr(self.step, '__name__', 'step')}: {names['input']} -> {names['output']}>"


def block(
    inputs: Declared = (),
    outputs: Declared = (),
    step: Step | None = None,
    *,
    parameters: Mapping[str, Any] | None = None,
    state: Any = None,
) -> Block:
    """
    Make a subsystem of a Python function.

    At each step from t to t + h the function is called once, `step(t, h, values)`, or `step(t, h, values,
    state)` where there is a state. It returns the outputs at t + h as a mapping; one that it leaves out keeps
    its value. `values` has inputs, parameters and the last outputs by name, as floats.

    Args:
        inputs: Names, or name to unit (`{"s": "m"}`); a name alone has the unit 1.
        outputs: Names, or name to unit, or name to `(start value, unit)`. At the start of a run an output
            has its start value (0).
        step: The function.
        parameters: Name to value, or to `(value, unit)`; they can be set as those of an FMU.
        state: Anything that `copy.deepcopy` copies, such as a dict: each run begins with a copy, and the
            function changes it in place.

    Raises:
        ConfigError: If a name is used twice, a unit is not known, or `step` does not take these arguments.

    Example:
        >>> damper = block({"v": "m/s"}, {"f": "N"}, lambda t, h, u: {"f": -u["d"] * u["v"]},
        ...                parameters={"d": (65.0, "N s/m")})
    """
    declared = [("input", *one) for one in _declared(inputs)]
    declared += [("parameter", *one) for one in _declared(parameters or {}, values_first=True)]
    declared += [("output", *one) for one in _declared(outputs)]
    problems = _faults(declared, step, has_state=state is not None)
    if problems or step is None:
        raise ConfigError(problems)
    variables = tuple(
        Variable(
            name,
            reference,
            Kind.REAL,
            FLOAT64,
            causality,
            "tunable" if causality == "parameter" else "continuous",
            initial="exact" if causality != "input" else None,
            start=repr(float(start)),
            unit=None if name_of_unit is None else unit(name_of_unit),
        )
        for reference, (causality, name, start, name_of_unit) in enumerate(declared)
    )
    return Block(step, variables, state)


def _declared(given: Declared, *, values_first: bool = False) -> list[tuple[str, float, str | None]]:
    """List name, start value and name of the unit of each declaration."""
    if isinstance(given, str):
        given = (given,)
    if not isinstance(given, Mapping):
        return [(str(name), 0.0, None) for name in given]
    found = []
    for name, about in given.items():
        if isinstance(about, tuple):
            start, name_of_unit = about
            found.append((str(name), start, name_of_unit))
        elif isinstance(about, str) and not values_first:
            found.append((str(name), 0.0, about))
        else:
            found.append((str(name), about, None))
    return found


def _faults(
    declared: Sequence[tuple[str, str, float, str | None]], step: Step | None, *, has_state: bool
) -> list[Problem]:
    problems = []
    names = [name for _, name, _, _ in declared]
    for name in dict.fromkeys(n for n in names if names.count(n) > 1):
        problems.append(Problem("name is used twice", where=f"block: {name}", expected="names of their own"))
    for causality, name, start, name_of_unit in declared:
        where = f"block: {causality} {name}"
        if isinstance(start, bool) or not isinstance(start, int | float) or not math.isfinite(start):
            problems.append(Problem("not a value", where=where, got=repr(start), expected="a finite number"))
        try:
            unit(name_of_unit or "1")
        except (ValueError, TypeError, AttributeError) as error:
            problems.append(Problem(f"not a unit: {error}", where=where, got=repr(name_of_unit)))
    if not any(causality == "output" for causality, *_ in declared):
        problems.append(Problem("no outputs", where="block", expected="at least one"))
    if not callable(step):
        expected = "a function step(t, h, values)"
        problems.append(Problem("no function", where="block: step", got=repr(step), expected=expected))
        return problems
    arguments: tuple[Any, ...] = (0.0, 0.0, {}, {})[: 4 if has_state else 3]
    try:
        inspect.signature(step).bind(*arguments)
    except TypeError as error:
        expected = f"step(t, h, values{', state' if has_state else ''})"
        problems.append(Problem(f"arguments do not fit: {error}", where="block: step", expected=expected))
    except ValueError:
        pass  # a function of C that does not say what it takes
    return problems


@dataclass
class _Saved:
    values: dict[str, float]
    state: Any = field(repr=False)


_NOT_SERIALISED = "a Python function's state is any object, which goes into no file, expected an FMU"


class BlockSlave:
    """One instance of a block between its creation and its end; see `master.fmi.slave.Slave`."""

    def __init__(self, name: str, block: Block) -> None:
        self.name = name
        self.description = block.description(name)
        self._block = block
        self._names = [v.name for v in block.variables]
        self._is_output = {v.name: v.causality == "output" for v in block.variables}
        self._saved: dict[int, _Saved] = {}
        self._message = ""
        self.reset()
        self._functions = {
            "set": _EXCHANGE(self._take),
            "get": _EXCHANGE(self._give),
            "step": _DO_STEP(self._step),
            "get_state": _STATE_AT(self._save),
            "set_state": _STATE(self._restore),
            "free_state": _STATE_AT(self._free),
        }

    def interface(self) -> CInterface:
        at = {name: ctypes.cast(f, ctypes.c_void_p).value or 0 for name, f in self._functions.items()}
        return CInterface(
            version=2,
            component=0,
            do_step=at["step"],
            setters={_REAL: at["set"]},
            getters={_REAL: at["get"]},
            get_state=at["get_state"],
            set_state=at["set_state"],
            free_state=at["free_state"],
        )

    def reset(self) -> None:
        self._values = {v.name: float(v.start or 0.0) for v in self._block.variables}
        self._state = copy.deepcopy(self._block.state)

    def renew(self, *, failed: bool = False) -> None:
        self.reset()

    def enter_initialisation(
        self, start: Mapping[str, float | str], t0: float, stop: float | None = None
    ) -> None:
        self._values |= {name: float(value) for name, value in start.items()}

    def exit_initialisation(self) -> None:
        """Begin to step; nothing is left to do."""

    def set(self, variables: Sequence[Variable], values: Sequence[float]) -> None:
        self._values |= {v.name: float(value) for v, value in zip(variables, values, strict=True)}

    def get(self, variables: Sequence[Variable]) -> list[float]:
        return [self._values[v.name] for v in variables]

    def state_bytes(self) -> bytes:
        raise FmuError(self.name, _NOT_SERIALISED)

    def restore_bytes(self, data: bytes) -> None:
        raise FmuError(self.name, _NOT_SERIALISED)

    def last_message(self) -> str:
        return self._message

    def asked_for_end(self) -> bool:
        return False

    def process_fault(self) -> str:
        return ""

    def close(self, *, failed: bool, fatal: bool = False) -> None:
        self._saved.clear()

    def _take(self, _: int, references: Any, n: int, values: int) -> int:
        given = (ctypes.c_double * n).from_address(values)
        for i in range(n):
            self._values[self._names[references[i]]] = given[i]
        return Status.OK

    def _give(self, _: int, references: Any, n: int, values: int) -> int:
        wanted = (ctypes.c_double * n).from_address(values)
        for i in range(n):
            wanted[i] = self._values[self._names[references[i]]]
        return Status.OK

    def _step(self, _: int, t: float, h: float, __: int) -> int:
        more = () if self._block.state is None else (self._state,)
        try:
            found = self._block.step(t, h, dict(self._values), *more)
            for name, value in (found or {}).items():
                if not self._is_output.get(name, False):
                    raise KeyError(f"step returns {name!r}, expected an output")
                self._values[name] = float(value)
        except Exception as error:
            self._message = _described(error)
            return Status.ERROR
        return Status.OK

    def _save(self, _: int, place: Any) -> int:
        key = place[0] or 1 + max(self._saved, default=0)
        self._saved[key] = _Saved(dict(self._values), copy.deepcopy(self._state))
        place[0] = key
        return Status.OK

    def _restore(self, _: int, key: int) -> int:
        saved = self._saved[key]
        self._values = dict(saved.values)
        self._state = copy.deepcopy(saved.state)
        return Status.OK

    def _free(self, _: int, place: Any) -> int:
        self._saved.pop(place[0], None)
        place[0] = None
        return Status.OK


def _described(error: Exception) -> str:
    """Say what a function raised, and in which line."""
    *_, last = traceback.extract_tb(error.__traceback__)
    text = str(error.args[0]) if isinstance(error, KeyError) and error.args else str(error)
    return f"{type(error).__name__}: {text} ({Path(last.filename).name}:{last.lineno})"
