"""What the subcommands share: options, errors as text or JSON, progress."""

from __future__ import annotations

import functools
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from master.catalogue import FLAVOURS
from master.errors import EXIT_INPUT, ConfigError, FmuError, MasterError
from master.process.child import done_apart
from master.process.memory import TOO_LITTLE_MEMORY, is_of_memory, take_room_of_linear_algebra
from master.text.printable import printable

CONFIG = click.argument("config", type=click.Path(path_type=Path))
JSON = click.option("--json", "as_json", is_flag=True, help="Print one JSON object and nothing else.")
VARIANT = click.option("--variant", metavar="V", help="Take a named variant of the system.")
SET = click.option(
    "--set",
    "assignments",
    multiple=True,
    metavar="FMU.PARAMETER=VALUE",
    help="Set a value; may be repeated for other signals.",
)
INPUTS = click.option(
    "--inputs",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Drive inputs by the columns of a CSV (Parquet, NPZ, MAT) that are called as they are.",
)
STEP_SIZE = click.option(
    "--step-size", type=float, metavar="H", help="Step by H seconds instead of the file's step size."
)
FLAVOUR = click.option(
    "--flavour",
    type=click.Choice(FLAVOURS),
    default="native",
    show_default=True,
    help="Kind of FMU: native (FMI 2.0), fmi3 (native, FMI 3.0) or python.",
)


def system_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add CONFIG and what changes it: --variant, --set, --step-size, --flavour."""
    for option in reversed((CONFIG, VARIANT, SET, STEP_SIZE, FLAVOUR)):
        command = option(command)
    return command


_collected: list[str] | None = None  # in a child process: what this command says, for the parent to print


def say(text: str, *, err: bool = False) -> None:
    """Print text whose control characters, which a file may hold, do not reach the terminal."""
    if _collected is not None and not err:
        _collected.append(text)
        return
    try:
        click.echo(printable(text), err=err)
    except BrokenPipeError:  # the reader has seen enough, as `head` does
        stream = sys.stderr if err else sys.stdout
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def print_json(data: Any) -> None:
    """Print one object to standard output."""
    say(json.dumps(data, indent=2, allow_nan=False))


def answers_errors(command: Callable[..., None]) -> Callable[..., None]:
    """Turn a MasterError into text on standard error (or JSON) and its exit status."""

    @functools.wraps(command)
    def wrapped(*arguments: Any, **options: Any) -> None:
        try:
            command(*arguments, **options)
        except MasterError as error:
            problems = error.problems if isinstance(error, ConfigError) else [str(error)]
            if options.get("as_json"):
                print_json({"status": "failed", "problems": problems})
            for problem in problems:
                say(problem, err=True)
            sys.exit(error.exit_status)
        except Exception as error:
            if not is_of_memory(error):
                raise
            problem = TOO_LITTLE_MEMORY
            if options.get("as_json"):
                print_json({"status": "failed", "problems": [problem]})
            say(problem, err=True)
            sys.exit(EXIT_INPUT)

    return wrapped


def calls_fmus(command: Callable[..., None]) -> Callable[..., None]:
    """
    Let a command run in a child process, so that an FMU that ends its process is named.

    What FMUs print goes to standard error, what the command says to standard output, in the end.
    """

    @functools.wraps(command)
    def wrapped(*arguments: Any, **options: Any) -> None:
        try:
            texts = done_apart(lambda: _texts_of(command, arguments, options))
        except FmuError:
            from .console import STDERR

            STDERR.show_cursor()  # a progress bar hides it, and may have ended with the child
            raise
        for text in texts:
            say(text)

    return wrapped


def _texts_of(command: Callable[..., None], arguments: tuple[Any, ...], options: dict[str, Any]) -> list[str]:
    global _collected
    _collected = []
    try:
        take_room_of_linear_algebra()
        command(*arguments, **options)
        return _collected
    finally:
        _collected = None


def show_building(text: str) -> None:
    """Say what is being built."""
    from .console import STDERR

    STDERR.print(printable(text), style="dim", markup=False)
