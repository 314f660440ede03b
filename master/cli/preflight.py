"""`dockloop preflight`: is the system stable for every plant that the rig may be?"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, NamedTuple

import click

from master.commissioning.box import Box, default_box, read_box
from master.commissioning.methods import prepared_methods
from master.commissioning.preflight import Preflight, factors_text
from master.commissioning.preflight import preflight as judge
from master.commissioning.preflight_page import milliseconds, write_page
from master.errors import EXIT_DIVERGED
from master.experiment.prepare import Request
from master.installation import configuration
from master.process.child import done_apart

from .common import JSON, answers_errors, print_json, say, show_building, system_options
from .counted import counted_progress


@click.command()
@system_options
@click.option(
    "--box",
    "box_file",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="YAML file of what is not known; by default stiffness and lag +-20 %, damping +-30 %.",
)
@click.option(
    "--methods",
    metavar="METHOD,...",
    help="Methods in the place of the compensator, or all; without it the system as it is configured.",
)
@click.option(
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder for the page.",
)
@JSON
@answers_errors
def preflight(
    config: Path,
    box_file: Path | None,
    methods: str | None,
    output: Path | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Judge the stability of CONFIG for every plant that the rig may be; exit status 4 if one grows."""
    request = Request(**options)
    given = None if box_file is None else read_box(box_file)
    answer = done_apart(lambda: _judged(config, request, methods, given))
    folder = output or Path("results") / answer.name / (request.variant or "default")
    page = folder / "preflight.html"
    write_page(answer.title, answer.box, answer.found, page)
    if as_json:
        print_json(
            {
                "name": answer.name,
                "variant": request.variant,
                "box": answer.box.model_dump(by_alias=True, mode="json"),
                "methods": [one.as_dict() for one in answer.found],
                "page": str(page),
            }
        )
    else:
        say(f"{answer.title}: {answer.box.n_plants} plants")
        for one in answer.found:
            for line in _lines(one):
                say(line)
        say(f"page: {page}")
    sys.exit(0 if all(one.stable for one in answer.found) else EXIT_DIVERGED)


class _Answer(NamedTuple):
    """What comes back from the process that calls the FMUs."""

    name: str
    title: str
    box: Box
    found: list[Preflight]


def _judged(config: Path, request: Request, methods: str | None, given: Box | None) -> _Answer:
    prepared = list(prepared_methods(configuration(config), request, methods, show_building))
    box = given or default_box(prepared[0].experiment.config)
    found = []
    with counted_progress() as bar:
        task = bar.add_task("plants", total=len(prepared) * box.n_plants)
        for one in prepared:
            found.append(judge(one.experiment, box, one.method, lambda n: bar.advance(task, n)))
    return _Answer(prepared[0].experiment.name, prepared[0].experiment.title, box, found)


def _lines(one: Preflight) -> list[str]:
    nominal, worst = one.nominal, one.worst
    return [
        f"{one.method}: {one.sentence}",
        f"  nominal   zeta {nominal.zeta:+.6f} at {nominal.frequency:.4f} Hz, the force may come "
        f"{milliseconds(nominal.later)} ms later",
        f"  worst     zeta {worst.zeta:+.6f} at {worst.frequency:.4f} Hz, "
        f"with {factors_text(worst.factors)}; 2 zeta/w {milliseconds(one.closed_form)} ms",
    ]
