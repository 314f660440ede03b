"""Execution of a program's ticks, noted for whoever asks which FMU is called, and when."""

from __future__ import annotations

from master.process import position
from master.process.surroundings import restore_working_folder, working_folder

from .compiled import Execute
from .interpreter import DONE, Execution, LimitMonitor
from .program import Floats, Program


def execute_ticks(  # noqa: PLR0913 - what a tick is, which ticks, and where they go
    execute: Execute,
    program: Program,
    monitor: LimitMonitor,
    t0: float,
    h: float,
    begin: int,
    end: int,
    rows: Floats,
    pace: int | None = None,
) -> Execution:
    """
    Call `execute`, compiled or not, for the ticks from `begin` to before `end`.

    While it runs, and after an FMU failed in it, `position.current()` says whose call it is.
    """
    present = position.current()
    present.step(program.slaves, t0, h)
    folder = working_folder()
    ended = execute(program.memory, monitor, t0, h, begin, end, rows, pace=pace)
    restore_working_folder(folder)
    if ended.stop == DONE:
        present.rest(end)
    return ended
