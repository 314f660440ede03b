"""`dockloop linearise`: the third-order-plus-delay form of a motion simulator."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np

from master import catalogue
from master.docking.plant import AXES, TABULATED, Fit, fit, judge
from master.docking.plant import linearise as realised
from master.fmi.description_reader import read_description
from master.reproduce.facts.tables import LINEAR_PLANT

from .common import FLAVOUR, JSON, answers_errors, calls_fmus, print_json, say, show_building


@click.command()
@click.argument("model", metavar="MODEL")
@click.option("--axis", type=click.Choice(list(AXES)), default="z", show_default=True, help="Axis of motion.")
@FLAVOUR
@JSON
@answers_errors
@calls_fmus
def linearise(model: str, axis: str, flavour: str, as_json: bool) -> None:
    """Fit the linear motion simulator to one axis of MODEL (a model, or a path to an FMU)."""
    target = catalogue.locate(model, Path(), flavour)
    file = catalogue.files({model: target}, show_building)[model]
    system = realised(read_description(file), axis)
    fitted, given = fit(system, LINEAR_PLANT), judge(system, LINEAR_PLANT)
    if as_json:
        print_json(_as_dict(model, axis, fitted, given))
        return
    say("\n".join([f"{model}, axis {axis}, 0.1 to 5 Hz", *_lines(fitted, given)]))


def _as_dict(model: str, axis: str, fitted: Fit, given: Fit) -> dict[str, Any]:
    return {
        "model": model,
        "axis": axis,
        "fit": fitted.as_dict(),
        "configurations": given.as_dict(),
        "frequency": TABULATED.tolist(),
        "magnitude": np.abs(fitted.measured).tolist(),
        "phase_deg": np.degrees(np.angle(fitted.measured)).tolist(),
    }


def _lines(fitted: Fit, given: Fit) -> list[str]:
    rows = [f"  {'':<12}{'K_p':>9}{'w_v':>10}{'z':>9}{'dead time [ms]':>16}   largest error over the range"]
    for name, found in (("fit", fitted), ("configs", given)):
        form = found.form
        error = f"{100 * found.magnitude_error:.2f} % {found.phase_error:.2f} deg"
        values = f"{form.K_p:>9.3f}{form.w_v:>10.3f}{form.z:>9.4f}{1e3 * form.dead_time:>16.3f}"
        rows.append(f"  {name:<12}{values}   {error}")
    rows += ["", f"  {'f [Hz]':>8}{'model':>16}{'fit':>16}{'configs':>16}"]
    for row in zip(
        TABULATED, fitted.measured, fitted.form.at(TABULATED), given.form.at(TABULATED), strict=True
    ):
        shown = "".join(f"{abs(v):>8.4f}{np.degrees(np.angle(v)):>8.2f}" for v in row[1:])
        rows.append(f"  {row[0]:>8.2f}{shown}")
    return rows
