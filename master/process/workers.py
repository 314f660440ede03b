"""Processes that work for this one."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any, ParamSpec, TypeVar

from . import signals

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
    """Start n processes at most, by `spawn` or `fork`; an exception that ends the block ends them at once."""
    context: Any = multiprocessing.get_context(method)
    executor = ProcessPoolExecutor(n, mp_context=context)
    try:
        yield Workers(executor)
    except BaseException:
        for process in multiprocessing.active_children():
            process.kill()
        executor.shutdown(wait=False, cancel_futures=True)
        raise
    executor.shutdown()
