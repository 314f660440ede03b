"""`dockloop inspect`: what an FMU says of itself, and what is odd about it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import click

from master import catalogue
from master.fmi.description_reader import read_description
from master.fmi.inspection import InspectedVariable, Inspection, inspect_fmu

from .common import FLAVOUR, JSON, answers_errors, print_json, say, show_building

_ORDER = (
    "input",
    "output",
    "parameter",
    "calculatedParameter",
    "structuralParameter",
    "local",
    "independent",
)
_HEAD = ("name", "type", "unit", "start", "range", "variability", "meaning")


@click.command()
@click.argument("fmu", metavar="FMU")
@FLAVOUR
@JSON
@answers_errors
def inspect(fmu: str, flavour: str, as_json: bool) -> None:
    """Show variables, capabilities and platforms of an FMU, and what is odd about it; its code is not run."""
    target = catalogue.locate(fmu, Path(), flavour)
    file = catalogue.files({fmu: target}, show_building)[fmu]
    found = inspect_fmu(read_description(file))
    if as_json:
        print_json(found.as_dict())
        return
    for line in _lines(found):
        say(line.rstrip())


def _lines(found: Inspection) -> Iterator[str]:
    yield f"{found.name}, {found.path}"
    yield ""
    yield "capabilities"
    for name, value in found.capabilities.items():
        shown = {True: "yes", False: "no"}.get(value, value) if isinstance(value, bool) else value
        yield f"  {name:<42}{shown}"
    sources = ", and its sources" if found.has_sources else ""
    yield f"  {'platforms':<42}{', '.join(found.platforms) or 'none'}{sources}"
    for terminal, members in found.terminals.items():
        yield f"  {'terminal ' + terminal:<42}{', '.join(f'{m}: {v}' for m, v in members.items())}"
    for causality in _ORDER:
        chosen = [v for v in found.variables if v.causality == causality]
        if chosen:
            yield ""
            yield f"{causality}s"
            yield from _table([_HEAD, *map(_row, chosen)])
    yield ""
    yield "odd" if found.odd else "nothing odd"
    yield from (f"  {text}" for text in found.odd)


def _row(v: InspectedVariable) -> tuple[str, ...]:
    least, largest = ("" if bound is None else f"{bound:.6g}" for bound in (v.minimum, v.maximum))
    bounds = f"{least}..{largest}" if least or largest else ""
    if v.items:
        bounds = ", ".join(f"{number} {name}" for name, number in v.items.items())
    start = "" if v.start is None else f"{v.start:.9g}" if isinstance(v.start, float) else str(v.start)
    return (v.name, v.type, v.unit, start, bounds, v.variability, " ".join(v.description.split()))


def _table(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]) - 1)]
    for row in rows:
        cells = (f"{cell:<{width}}" for cell, width in zip(row, widths, strict=False))
        yield "  " + "  ".join([*cells, row[-1]])
