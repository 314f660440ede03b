"""`dockloop check`: read and validate a system or a case without running it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from master.errors import ConfigError
from master.installation import configuration
from master.process.surroundings import standard_output_as_error
from master.text.yaml_lines import read_yaml

from .common import INPUTS, JSON, answers_errors, print_json, say, show_building, system_options


@click.command()
@system_options
@INPUTS
@click.option(
    "--plot",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE.png",
    help="Of a case: replay the models as they are, and draw them over what was measured.",
)
@JSON
@answers_errors
def check(config: Path, plot: Path | None, as_json: bool, **options: Any) -> None:
    """Validate CONFIG, a system or a case: every fault at once, or one line that says what is in it."""
    if _is_case(config):
        _check_case(config, plot, as_json, [name for name, value in options.items() if _is_given(value)])
        return
    if plot is not None:
        raise ConfigError(
            [f"--plot: {config} is a system, expected a case; a run draws a system: dockloop run {config}"]
        )
    from master.experiment.prepare import Request, prepare
    from master.fmi.unpacked import require_runnable

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


def _check_case(path: Path, plot: Path | None, as_json: bool, given: list[str]) -> None:
    from master.diagnosis.judge.checked import check_case

    if given:
        raise ConfigError(
            [f"{path}: a case, got --{given[0].replace('_', '-')}, expected no option of a system"]
        )
    if plot is not None and plot.suffix.lower() != ".png":
        raise ConfigError([f"--plot: {plot}, got {plot.suffix!r}, expected a file that ends in .png"])
    with standard_output_as_error():  # what a model of one's own prints
        found = check_case(path, show_building)
    if plot is not None:
        _draw(path, plot)
    if as_json:
        parts = [{"fmus": p.name, "compared": p.compared, "effects": p.n_effects} for p in found.parts]
        counts = {"rows": found.rows, "period": found.period, "fit": found.n_fit, "select": found.n_select}
        more: dict[str, Any] = {"cost": found.cost.as_dict(), "notes": found.notes}
        if plot is not None:
            more["plot"] = str(plot)
        print_json({"name": found.name, "status": "valid", **counts, "parts": parts, **more})
        return
    rows = ", ".join(f"{name} {n} rows" for name, n in found.rows.items())
    say(f"{path}: valid, {rows} every {found.period:.6g} s")
    for name, notes in found.notes.items():
        for note in notes:
            say(f"{name}: {note}")
    say(f"split: {found.n_fit} rows to fit, {found.n_select} to select by, the others sealed or left out")
    for part in found.parts:
        say(f"{part.name}: compared in {', '.join(part.compared)}, {part.n_effects} effects to consider")
    say(f"{found.cost}")
    if plot is not None:
        say(f"{plot}: the models as they are, over what was measured")


def _draw(case: Path, plot: Path) -> None:
    """Draw in a child process, so that an FMU that ends its process is named."""
    from master.diagnosis.answer.nominal_picture import draw_nominal
    from master.installation import require_native
    from master.process.child import done_apart

    require_native("check --plot")
    done_apart(lambda: draw_nominal(case, plot))
