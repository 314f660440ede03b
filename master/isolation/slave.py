"""An FMU in a process of its own, as a slave: it differs from others only in how it fails."""

from __future__ import annotations

import base64
import ctypes
import math
import os
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from master.errors import ConfigError, FmuError
from master.fmi import messages
from master.fmi.description import Description, Variable
from master.fmi.native import sharing
from master.fmi.slave import CInterface, Slave
from master.fmi.status import Status, described
from master.process import child, position
from master.process.position import Call

from . import fmu_process
from . import layout as at
from .channel import Channel
from .compiled import functions
from .layout import Fault, Request
from .options import DEADLINE, HOLD, MEGABYTE, Isolation

_PATIENCE_SECONDS = 2.0
_LOOKS = 2000
_NEARLY_ALL = 0.8

_FUNCTIONS = {
    "load": {2: "fmi2Instantiate", 3: "fmi3InstantiateCoSimulation"},
    "enter_initialisation": {2: "fmi2EnterInitializationMode", 3: "fmi3EnterInitializationMode"},
    "exit_initialisation": {2: "fmi2ExitInitializationMode", 3: "fmi3ExitInitializationMode"},
    "reset": {2: "fmi2Reset", 3: "fmi3Reset"},
    "renew": {2: "fmi2Instantiate", 3: "fmi3InstantiateCoSimulation"},
    "set": {2: "fmi2SetXXX", 3: "fmi3SetXXX"},
    "get": {2: "fmi2GetXXX", 3: "fmi3GetXXX"},
    "state_bytes": {2: "fmi2SerializeFMUstate", 3: "fmi3SerializeFMUState"},
    "restore_bytes": {2: "fmi2DeSerializeFMUstate", 3: "fmi3DeserializeFMUState"},
    "asked_for_end": {2: "fmi2GetBooleanStatus", 3: "fmi3GetXXX"},
    "close": {2: "fmi2FreeInstance", 3: "fmi3FreeInstance"},
}

Factory = Callable[[str, Description], Slave]


class IsolatedSlave:
    """
    One instance whose process is forked on creation, and ends with it.

    The process that steps and the FMU's take turns: where there are fewer isolated FMUs than processors, each
    side looks for the other's word for a moment, else all of them work on one processor, where sleeping and
    waking is cheapest (measured in `docs/isolation.md`).
    """

    def __init__(
        self,
        name: str,
        description: Description,
        isolation: Isolation,
        factory: Factory,
        n_isolated: int = 1,
    ) -> None:
        self.name = name
        self.description = description
        self._isolation = isolation
        self._is_said = False
        self._channel = Channel(len(description.variables))
        self._held = np.zeros(self._channel.values_bytes, dtype=np.uint8)
        self._plan = np.zeros((at.MOST_PLANNED, at.PLAN_WIDTH), dtype=np.int64)
        self._desk = np.zeros(at.N_DESK, dtype=np.int64)
        self._functions = functions()  # before the fork: the other process has them then
        self._folder = tempfile.TemporaryDirectory(prefix="dockloop-", ignore_cleanup_errors=True)
        self._fork(factory, _looks(n_isolated))
        messages.current().add_source(self._collect)
        try:
            self._request("load")
        except BaseException:
            self._end()
            raise

    def interface(self) -> CInterface:
        version, made = self.description.version, self._functions
        saves = self.description.can_get_and_set_state
        return CInterface(
            version=version,
            component=self._desk.ctypes.data,
            do_step=made.step[version],
            get_state=made.save if saves else 0,
            set_state=made.restore if saves else 0,
            free_state=made.free if saves else 0,
            setters=made.setters[version],
            getters=made.getters[version],
        )

    def enter_initialisation(
        self, start: Mapping[str, float | str], t0: float, stop: float | None = None
    ) -> None:
        self._request("enter_initialisation", dict(start), t0, stop)

    def exit_initialisation(self) -> None:
        self._request("exit_initialisation")

    def reset(self) -> None:
        messages.current().forget(self.name)
        self._desk[at.N_STEPS] = 0
        self._request("reset")

    def renew(self, *, failed: bool = False) -> None:
        messages.current().forget(self.name)
        self._desk[at.N_STEPS] = 0
        self._request("renew", failed)

    def set(self, variables: Sequence[Variable], values: Sequence[float]) -> None:
        if not self._is_holding():
            self._request("set", [v.name for v in variables], list(values))

    def get(self, variables: Sequence[Variable]) -> list[float]:
        found = self._request("get", [v.name for v in variables])
        try:
            numbers = [v if isinstance(v, int) else float(v) for v in found]
        except (TypeError, ValueError):
            raise self._garbled() from None
        if len(numbers) != len(variables):
            raise self._garbled()
        return numbers

    def state_bytes(self) -> bytes:
        try:
            return base64.b64decode(self._request("state_bytes"), validate=True)
        except (TypeError, ValueError):
            raise self._garbled() from None

    def restore_bytes(self, data: bytes) -> None:
        self._request("restore_bytes", base64.b64encode(data).decode())

    def last_message(self) -> str:
        self._collect()
        return messages.current().of_call(self.name)

    def asked_for_end(self) -> bool:
        return bool(self._request("asked_for_end"))

    def process_fault(self) -> str:
        """Say how the FMU's process failed, empty while it goes on."""
        fault = self._fault()
        if fault in (Fault.NONE, Fault.REFUSED):
            return ""
        call = self._channel.position.call()
        within = f"in {call.function}" if call else "in no call of the FMU"
        if fault == Fault.HUNG:
            named = call.function if call else "a call"
            said = f"did not return from {named} within {self._isolation.deadline:g} s, and was ended"
        else:
            said = f"ended its process, {child.ending_of(int(self._desk[at.WAIT_STATUS]))}, {within}"
            said += self._of_memory()
        heard = messages.current().text_of(self.name, call)
        return f"{said}, after it said {heard}" if heard else said

    def close(self, *, failed: bool, fatal: bool = False) -> None:
        if self._fault() == Fault.NONE:
            with suppress(FmuError):  # what it did in its last call spoils no results any more
                self._request("close", failed, fatal)
        fault = self.process_fault()
        if fault and not failed and not self._is_said:
            messages.current().note(self.name, Status.ERROR, messages.AT_THE_END, fault)
        self._end()

    def _fork(self, factory: Factory, looks: int) -> None:
        here = position.current()
        cells = self._channel.position.cells
        cells[position.T0] = here.cells[position.T0]
        cells[position.STEP_SIZE] = here.cells[position.STEP_SIZE]
        desk = self._desk
        desk[at.CHANNEL] = self._channel.address
        desk[at.KERNEL] = sharing.kernel_entry()
        desk[at.LOOKS] = looks
        desk[at.POSITION] = here.address()
        desk[at.SETS_AT] = self._channel.sets_at
        desk[at.SETS_BYTES] = self._channel.values_bytes
        desk[at.GETS_AT] = self._channel.gets_at
        desk[at.GETS_BYTES] = self._channel.values_bytes
        desk[at.HOLDS] = self._isolation.on_fault == HOLD
        desk[at.HELD] = self._held.ctypes.data
        desk[at.PLAN] = self._plan.ctypes.data
        sys.stdout.flush()
        sys.stderr.flush()
        parent = os.getpid()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # threads of numeric libraries, at rest
            process = os.fork()
        if process == 0:
            fmu_process.run(
                self.name,
                self.description,
                self._isolation,
                self._channel,
                self._folder.name,
                looks,
                factory,
                parent,
            )
        desk[at.PROCESS] = process
        self._channel.share_no_further()

    def _request(self, method: str, *arguments: Any) -> Any:
        """Ask for a slow call and return its result."""
        if self._fault() != Fault.NONE:
            raise self._error()
        here = position.current()
        here.check_stop()
        here.enter(self.name, _FUNCTIONS[method][self.description.version])
        seconds = self._isolation.deadline
        if method == "load":
            seconds = max(seconds, DEADLINE)
        self._desk[at.DEADLINE] = round(seconds * 1e9)
        try:
            self._channel.put([method, arguments])
            lost = self._functions.ask(self._desk.ctypes.data, Request.CALL)
        finally:
            here.leave()
            self._desk[at.DEADLINE] = round(self._isolation.deadline * 1e9)
        self._collect()
        if lost:
            raise self._error()
        try:
            answer = self._channel.get()
            return self._result(answer)
        except (ValueError, TypeError, LookupError):
            raise self._garbled() from None

    def _result(self, answer: Any) -> Any:
        if "fmu_error" in answer:
            text, t, status = answer["fmu_error"]
            raise FmuError(self.name, str(text), time=t, status=str(status))
        if "config_error" in answer:
            raise ConfigError([str(problem) for problem in answer["config_error"]])
        if "error" in answer:
            raise FmuError(self.name, str(answer["error"]), time=position.current().time())
        return answer["result"]

    def _garbled(self) -> FmuError:
        said = "its process answered with something else than asked for"
        return FmuError(self.name, said, time=position.current().time(), status="fatal")

    def _error(self) -> FmuError:
        said = self.process_fault() or "is not called any more after an error"
        return FmuError(self.name, said, time=position.current().time(), status="fatal")

    def _fault(self) -> Fault:
        return Fault(int(self._desk[at.FAULT]))

    def _is_holding(self) -> bool:
        return bool(self._fault() and self._desk[at.HOLDS] and self._desk[at.N_STEPS])

    def _of_memory(self) -> str:
        """How much memory the process used, if that is much of what it may."""
        used = int(self._desk[at.MOST_RESIDENT]) * 1024
        limit = fmu_process.memory_limit(self._isolation)
        if used < _NEARLY_ALL * limit:
            return ""
        return f", with {used // MEGABYTE} MB of memory where it may take {limit // MEGABYTE} MB"

    def _collect(self) -> None:
        """Take the messages that came, and say what else there is to say of the process."""
        log = messages.current()
        came, lost = self._channel.received()
        for one in came:
            with suppress(TypeError, ValueError):
                status, category, text, where = one
                call = (
                    None if where is None else Call(self.name, str(where[0]), int(where[1]), bool(where[2]))
                )
                log.take(self.name, int(status), str(category), str(text), call)
        if lost:
            log.note(self.name, Status.WARNING, "", f"{lost} messages came faster than they could be kept")
        cells = self._channel.position.cells
        if cells[position.FLOAT_MODE] == 1.0:
            cells[position.FLOAT_MODE] = 0.0
            tick = cells[position.FLOAT_TICK]
            call = Call(self.name, _FUNCTIONS["load"][self.description.version], _whole(tick), True)
            log.take(self.name, Status.WARNING, "floating point", messages.CHANGES_FLOAT_MODE, call)
        if self._is_holding() and not self._is_said:
            self._is_said = True
            fault = self.process_fault()
            if not fault:
                fault = f"answered with {described(int(self._desk[at.FAULT_STATUS]))}"
            call = Call(self.name, "", int(self._desk[at.FAULT_TICK]), True)
            log.take(self.name, Status.ERROR, "held", f"{fault}; its last values are held", call)

    def _end(self) -> None:
        """End the process and remove its folder."""
        process = int(self._desk[at.PROCESS])
        if process > 0:
            self._desk[at.PROCESS] = 0
            _await(process)
        self._folder.cleanup()


def _await(process: int) -> None:
    """Wait a while for a process to end, then end it."""
    until = time.monotonic() + _PATIENCE_SECONDS
    pause = 0.0005
    with suppress(ChildProcessError):
        while os.waitpid(process, os.WNOHANG)[0] == 0:
            if time.monotonic() > until:
                os.kill(process, 9)
                os.waitpid(process, 0)
                return
            time.sleep(pause)
            pause = min(2 * pause, 0.05)


def _looks(n_isolated: int) -> int:
    """How often each side looks for the other before it sleeps; if never, let them share a processor."""
    processors = os.sched_getaffinity(0)
    if n_isolated < len(processors):
        return _LOOKS
    if child.is_child() and len(processors) > 1:
        with suppress(OSError, AttributeError):
            os.sched_setaffinity(0, {ctypes.CDLL(None).sched_getcpu()})
    return 0


def _whole(number: float) -> int:
    return int(number) if math.isfinite(number) else 0
