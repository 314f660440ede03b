"""Processes that work for this one."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any, ParamSpec, TypeVar

from . import memory, signals
from .child import leave_at_exit

P = ParamSpec("P")
T = TypeVar("T")


class Workers:
    """A pool of processes; signals, which a terminal sends to all of them, are this process's matter."""

    def __init__(self, executor: ProcessPoolExecutor) -> None:
        self._executor = executor

    def submit(self, work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> Future[T]:
        """Have some work done."""
        with signals.held():  # a process that starts here inherits that
            return self._executor.submit(work, *arguments, **named)


@contextmanager
def workers(n: int, method: str) -> Iterator[Workers]:
    """
    Start n processes at most, by `spawn` or `fork`; an exception that ends the block ends them at once.

    Raises:
        MasterError: If a limit of the address space leaves too little for them.
        BrokenExecutor: If one of them ends while its work is waited for; see `each_needed`.
    """
    memory.require_room_for_libraries()  # a pool whose own threads cannot start waits for ever
    context: Any = multiprocessing.get_context(method)
    is_forked = method == "fork"
    executor = ProcessPoolExecutor(n, mp_context=context, initializer=leave_at_exit if is_forked else None)
    try:
        yield Workers(executor)
    except BaseException:
        for process in multiprocessing.active_children():
            process.kill()
        executor.shutdown(wait=False, cancel_futures=True)
        raise
    executor.shutdown()


@contextmanager
def each_needed() -> Iterator[None]:
    """
    Around `workers`: take one that ended for one without memory, where nothing can be done in its place.

    Raises:
        MasterError: If one ended, and the address space is limited.
    """
    try:
        yield
    except BrokenExecutor:
        memory.raise_if_limited("a process that works for the command ended")
        raise
