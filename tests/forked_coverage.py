"""Coverage counts what forked processes do, in which systems are stepped: each saves it when it ends."""

from __future__ import annotations

import os
from contextlib import suppress
from typing import NoReturn

from coverage import Coverage

_end = os._exit


def count_forked_processes() -> None:
    """
    Let each process that is forked from now on save the lines that it has run, where coverage is measured.

    Coverage's own patch of `os._exit` is put around itself again after each test that is not measured, and
    its patch of `fork` begins anew in each child, which processes of FMUs do not bear.
    """
    os.register_at_fork(after_in_child=_forget_the_lines_of_the_parent)
    os._exit = _save_and_end


def _forget_the_lines_of_the_parent() -> None:
    measured = Coverage.current()
    collector = getattr(measured, "_collector", None)
    for lines in list(getattr(collector, "data", {}).values()):
        lines.clear()


def _save_and_end(status: int) -> NoReturn:
    with suppress(BaseException):  # what an FMU has done to its process is no matter of the test
        measured = Coverage.current()
        if measured is not None:
            measured.stop()
            measured.save()
    _end(status)
