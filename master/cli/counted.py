"""A bar of work that is counted; a file of its own, since `rich.progress` takes its time to load."""

from __future__ import annotations

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from .console import STDERR


def counted_progress() -> Progress:
    """Return a bar on standard error that says what is done, how many of how many, and for how long."""
    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        console=STDERR,
    )
