"""`dockloop new`: a draft of a system from FMUs, every guess marked."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import click

from master import catalogue
from master.errors import ConfigError, Problem
from master.experiment.draft import Part, draft
from master.fmi.description_reader import read_description
from master.fmi.inspection import inspect_fmu
from master.recording.folder import reason

from .common import FLAVOUR, answers_errors, say, show_building


@click.command()
@click.argument("fmus", nargs=-1, required=True, metavar="FMU...")
@click.option(
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    default=Path("system.yaml"),
    show_default=True,
    metavar="FILE",
    help="The file to write; none is replaced.",
)
@FLAVOUR
@answers_errors
def new(fmus: tuple[str, ...], output: Path, flavour: str) -> None:
    """Draft a system of FMUs (paths, or names of models): wires are guessed, and each guess is marked."""
    if output.exists():
        raise ConfigError([Problem("is there already", where=str(output), expected="another --output")])
    parts = _parts(fmus, output.absolute().parent, flavour)
    lines = draft(output.stem, parts)
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        raise ConfigError([Problem(f"cannot be written: {reason(error)}", where=str(output))]) from None
    wires = sum(line.startswith("  - {from") for line in lines)
    open_ends = sum(line.startswith("# not connected") for line in lines)
    say(f"{output}: {len(parts)} FMUs, {wires} connections guessed, {open_ends} inputs not connected")


def _parts(fmus: Sequence[str], folder: Path, flavour: str) -> dict[str, Part]:
    """Read the FMUs; each gets a name of its own, and a source as seen from the folder of the file."""
    targets = []
    problems = []
    for source in fmus:
        try:
            targets.append(catalogue.locate(source, Path(), flavour))
        except ConfigError as error:
            problems += error.problems
    if problems:
        raise ConfigError(problems)
    files = catalogue.files({str(i): target for i, target in enumerate(targets)}, show_building)
    parts: dict[str, Part] = {}
    for i, source in enumerate(fmus):
        description = read_description(files[str(i)])
        shown = os.path.relpath(source, folder) if catalogue.is_path(source) else source
        if catalogue.is_path(source) and not catalogue.is_path(shown):
            shown = f"./{shown}"
        name = _free_name(Path(source).name.removesuffix(".fmu"), parts)
        parts[name] = Part(shown, description, inspect_fmu(description))
    return parts


def _free_name(wanted: str, taken: dict[str, Part]) -> str:
    """Make a name that signals can be made of, and that no other FMU has."""
    plain = "".join("_" if c.isspace() or c in ".<>" else c for c in wanted) or "fmu"
    numbered = (f"{plain}_{i}" for i in range(2, len(taken) + 3))
    return plain if plain not in taken else next(name for name in numbered if name not in taken)
