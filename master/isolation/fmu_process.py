"""The process of an isolated FMU, from its fork to its end."""

from __future__ import annotations

import base64
import contextlib
import os
import resource
import tempfile
import threading
import traceback
from collections.abc import Callable
from typing import Any

import numpy as np

from master.errors import ConfigError, FmuError
from master.fmi import messages
from master.fmi.description import Description, Variable
from master.fmi.messages import MessageLog
from master.fmi.native import sharing
from master.fmi.slave import Slave
from master.process import child, position, signals
from master.process.surroundings import standard_output_as_error

from . import layout as at
from .channel import Channel
from .compiled import functions
from .options import MEGABYTE, Isolation
from .sandbox import shut_in
from .serve import LAST

Factory = Callable[[str, Description], Slave]


class _Forwarding(MessageLog):
    """Passes on what the FMU says."""

    def __init__(self, channel: Channel) -> None:
        super().__init__()
        self._channel = channel

    def note(self, fmu: str, status: int, category: str, text: str) -> None:
        super().note(fmu, status, category, text)
        call = position.current().call()
        where = None if call is None else [call.function, call.tick, call.is_in_loop]
        self._channel.send([status, category, text, where])

    def _count(self, *_: Any) -> None:
        """Leave that to the other side."""


def run(
    name: str,
    description: Description,
    isolation: Isolation,
    channel: Channel,
    folder: str,
    looks: int,
    factory: Factory,
    parent: int,
) -> None:
    """
    In the forked process: load the FMU and answer requests, until it is asked to end; never returns.

    Args:
        name: Instance.
        description: Its FMU.
        isolation: Limits of the process.
        channel: Memory shared with the other process.
        folder: For all that the FMU writes.
        looks: How often to look for a request before sleeping.
        factory: Loads the FMU.
        parent: Number of the process that asks.
    """
    status = 1
    try:
        with standard_output_as_error(), position.using(channel.position):
            channel.share_no_further()
            last_work = _prepare(isolation, folder, parent)
            with messages.collecting(_Forwarding(channel)):
                _FmuProcess(name, description, channel, looks, factory, parent).answer_requests()
            for work in last_work:
                work()
        status = 0
    except Exception:
        traceback.print_exc()  # a fault of this program, as what the FMU does is an answer
    finally:
        os._exit(status)


def _prepare(isolation: Isolation, folder: str, parent: int) -> list[Callable[[], Any]]:
    """Leave the other process's matters to it, and keep to the limits; return what is to be done last."""
    signals.forget()
    if threading.current_thread() is threading.main_thread():
        child.die_with(parent)
    child.leave_at_exit()
    os.closerange(3, os.sysconf("SC_OPEN_MAX"))
    tempfile.tempdir = os.environ["TMPDIR"] = folder
    with contextlib.suppress(OSError), open("/proc/self/oom_score_adj", "w") as file:
        file.write("1000")  # where memory runs out, the kernel ends this process first
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    limit = memory_limit(isolation) + _data_bytes()
    resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
    if isolation.is_sandboxed:
        shut_in(folder)
    return child.put_off_last_work()


def memory_limit(isolation: Isolation) -> int:
    """Return how much the FMU may allocate [bytes]."""
    if isolation.memory is not None:
        return isolation.memory * MEGABYTE
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2


def _data_bytes() -> int:
    """Private memory that the process has, as RLIMIT_DATA counts it [bytes]."""
    with open("/proc/self/status", encoding="ascii") as file:
        [kilobytes] = [line.split()[1] for line in file if line.startswith("VmData:")]
    return int(kilobytes) * 1024


class _FmuProcess:
    """Answers requests: the fast ones in compiled code, the others here."""

    def __init__(
        self,
        name: str,
        description: Description,
        channel: Channel,
        looks: int,
        factory: Factory,
        parent: int,
    ) -> None:
        self._name = name
        self._description = description
        self._channel = channel
        self._factory = factory
        self._loaded: Slave | None = None
        self._desk = np.zeros(at.N_DESK, dtype=np.int64)
        self._desk[at.CHANNEL] = channel.address
        self._desk[at.KERNEL] = sharing.kernel_entry()
        self._desk[at.LOOKS] = looks
        self._desk[at.POSITION] = channel.position.address()
        self._desk[at.SETS_AT] = channel.sets_at
        self._desk[at.GETS_AT] = channel.gets_at
        self._desk[at.PARENT] = parent

    def answer_requests(self) -> None:
        """Answer until the FMU is asked to end, or the other process is gone."""
        serve = functions().serve
        address = self._desk.ctypes.data
        cells = self._channel.position.cells
        slaves = [(self._name, self._description.version)]
        self._channel.position.step(slaves, cells[position.T0], cells[position.STEP_SIZE])
        while serve(address):
            method, arguments = self._channel.get()
            answer = self._answer(method, arguments)
            try:
                self._channel.put(answer)
            except ValueError as error:
                self._channel.put({"error": f"{method}: {error}"})
            if method == "close":
                self._desk[at.IS_ASKED] = LAST

    def _answer(self, method: str, arguments: list[Any]) -> dict[str, Any]:
        try:
            return {"result": getattr(self, f"_{method}")(*arguments)}
        except FmuError as error:
            return {"fmu_error": [error.message, error.time, error.status]}
        except ConfigError as error:
            return {"config_error": [str(problem) for problem in error.problems]}
        except Exception as error:
            return {"error": f"{type(error).__name__}: {error}"}

    @property
    def _slave(self) -> Slave:
        if self._loaded is None:
            raise RuntimeError("not loaded")
        return self._loaded

    def _variables(self, names: list[str]) -> list[Variable]:
        return [self._description.by_name[name] for name in names]

    def _load(self) -> None:
        self._loaded = self._factory(self._name, self._description)
        self._show_interface()

    def _renew(self, failed: bool) -> None:
        self._slave.renew(failed=failed)
        self._show_interface()

    def _show_interface(self) -> None:
        """Write where the FMU's functions and its instance are."""
        interface = self._slave.interface()
        desk = self._desk
        desk[at.VERSION] = interface.version
        desk[at.COMPONENT] = interface.component
        desk[at.DO_STEP] = interface.do_step
        desk[at.GET_STATE] = interface.get_state
        desk[at.SET_STATE] = interface.set_state
        desk[at.FREE_STATE] = interface.free_state
        for first, functions_of_type in ((at.SETTERS, interface.setters), (at.GETTERS, interface.getters)):
            for (_, value_type), address in functions_of_type.items():
                desk[first + value_type] = address

    def _enter_initialisation(self, start: dict[str, float | str], t0: float, stop: float | None) -> None:
        self._slave.enter_initialisation(start, t0, stop)

    def _exit_initialisation(self) -> None:
        self._slave.exit_initialisation()

    def _reset(self) -> None:
        self._slave.reset()

    def _set(self, names: list[str], values: list[float]) -> None:
        self._slave.set(self._variables(names), values)

    def _get(self, names: list[str]) -> list[float]:
        return self._slave.get(self._variables(names))

    def _state_bytes(self) -> str:
        return base64.b64encode(self._slave.state_bytes()).decode()

    def _restore_bytes(self, text: str) -> None:
        self._slave.restore_bytes(base64.b64decode(text))

    def _asked_for_end(self) -> bool:
        return self._slave.asked_for_end()

    def _close(self, failed: bool, fatal: bool) -> None:
        if self._loaded is not None:
            self._loaded.close(failed=failed, fatal=fatal)
