"""`dockloop check`: read and validate a system without running it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from master.experiment.prepare import Request, prepare
from master.fmi.unpacked import require_runnable

from .common import (
    CONFIG,
    FLAVOUR,
    INPUTS,
    JSON,
    SET,
    STEP_SIZE,
    VARIANT,
    answers_errors,
    print_json,
    say,
    show_building,
)


@click.command()
@CONFIG
@VARIANT
@SET
@INPUTS
@STEP_SIZE
@FLAVOUR
@JSON
@answers_errors
def check(config: Path, as_json: bool, **options: Any) -> None:
    """Validate CONFIG: every fault at once, or one line that says what is in it."""
    experiment = prepare(config, Request(**options), show_building)
    require_runnable(i.description for i in experiment.system.instances.values())
    counts = {
        "fmus": len(experiment.system.instances),
        "connections": len(experiment.system.wires),
        "variants": experiment.n_variants,
        "steps": experiment.grid.n_ticks,
    }
    if as_json:
        print_json({"name": experiment.name, "status": "valid", **counts, "notes": experiment.notes})
        return
    say(f"{config}: valid, " + ", ".join(f"{n} {what}" for what, n in counts.items()))
    for note in experiment.notes:
        say(f"note: {note}")
