"""`dockloop check`: read and validate a system or a case without running it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from master.errors import ConfigError
from master.experiment.prepare import Request, prepare
from master.fmi.unpacked import require_runnable
from master.installation import configuration
from master.text.yaml_lines import read_yaml

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
    """Validate CONFIG, a system or a case: every fault at once, or one line that says what is in it."""
    if _is_case(config):
        _check_case(config, as_json, [name for name, value in options.items() if _is_given(value)])
        return
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


def _is_case(config: Path) -> bool:
    """Whether a file is a case: a YAML with recordings."""
    path = configuration(config)
    if path.suffix.lower() not in (".yaml", ".yml"):
        return False
    try:
        return bool(read_yaml(path).names_in("recordings"))
    except ConfigError:
        return False


def _is_given(value: object) -> bool:
    return value not in (None, (), "native")


def _check_case(path: Path, as_json: bool, given: list[str]) -> None:
    from master.diagnosis.judge.checked import check_case

    if given:
        raise ConfigError(
            [f"{path}: a case, got --{given[0].replace('_', '-')}, expected no option of a system"]
        )
    found = check_case(path, show_building)
    if as_json:
        parts = [{"fmus": p.name, "compared": p.compared, "effects": p.n_effects} for p in found.parts]
        counts = {"rows": found.rows, "period": found.period, "fit": found.n_fit, "select": found.n_select}
        cost = {"rows_of_one_pass": found.rows_of_one_pass}
        print_json({"name": found.name, "status": "valid", **counts, "parts": parts, **cost})
        return
    rows = ", ".join(f"{name} {n} rows" for name, n in found.rows.items())
    say(f"{path}: valid, {rows} every {found.period:.6g} s")
    say(f"split: {found.n_fit} rows to fit, {found.n_select} to select by, the others sealed or left out")
    for part in found.parts:
        say(f"{part.name}: compared in {', '.join(part.compared)}, {part.n_effects} effects to consider")
    say(f"each effect once on the rows to fit: {found.rows_of_one_pass} rows to step")
