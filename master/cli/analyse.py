"""`dockloop analyse`: poles, margins and stability maps of the coupled, scheduled system."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray
from rich.progress import Progress

from master.analysis.closed_loop.linearise import Linearisation
from master.analysis.measures.map_plot import plot_map
from master.analysis.measures.sweep import Axis, StabilityMap, parse_axis, stability_map
from master.analysis.measures.zeros import zeros
from master.analysis.summary import judge, lines, pole_dict
from master.api import prepare_to_run
from master.errors import ConfigError, expected
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request

from .common import JSON, answers_errors, calls_fmus, print_json, say, show_building, system_options
from .console import STDERR


@click.command()
@system_options
@click.option(
    "--sweep",
    "sweeps",
    multiple=True,
    metavar="FMU.PARAMETER=FROM:TO:N",
    help="Stability over one or two parameters or extra delays [s] of connected inputs; writes a PNG.",
)
@click.option("--zeros", "pair", metavar="INPUT:OUTPUT", help="Zeros from a connected input to an output.")
@click.option(
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder for the stability map.",
)
@JSON
@answers_errors
@calls_fmus
def analyse(
    config: Path,
    sweeps: tuple[str, ...],
    pair: str | None,
    output: Path | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Poles, damping, and how much more delay and gain each connection of CONFIG bears."""
    request = Request(**options)
    experiment = prepare_to_run(config, request, show_building)
    if len(sweeps) > 2:
        raise ConfigError([f"--sweep: too many, got {len(sweeps)}, expected one or two"])
    linearisation = Linearisation(experiment, after_run=True)
    title = " / ".join(filter(None, (experiment.name, request.variant)))
    answer: dict[str, Any] = {"name": experiment.name, "variant": request.variant}
    if sweeps:
        folder = output or Path("results") / experiment.name / (request.variant or "default")
        found = _sweep(linearisation, sweeps)
        folder.mkdir(parents=True, exist_ok=True)
        answer |= _map_dict(found) | {"plot": str(plot_map(found, title, folder / "stability.png"))}
        text = _map_lines(answer)
    else:
        analysis = judge(linearisation.coupled(), linearisation)
        answer |= analysis.as_dict()
        text = lines(analysis)
        if pair is not None:
            answer["zeros"] = _zeros(linearisation, experiment, pair)
            text += ["", "zeros", *(f"  {z['frequency']:>10.4f}{z['zeta']:>12.6f}" for z in answer["zeros"])]
    if as_json:
        print_json(answer)
        return
    say("\n".join([title, *text]))


def _sweep(linearisation: Linearisation, sweeps: tuple[str, ...]) -> StabilityMap:
    x, *more = [parse_axis(text, linearisation.system) for text in sweeps]
    y = more[0] if more else None
    total = len(x.values) if x.wire is None or y is None else len(y.values)
    with Progress(console=STDERR, transient=True) as bar:
        task = bar.add_task("sweeping", total=total)
        return stability_map(linearisation, x, y, lambda: bar.advance(task))


def _map_dict(found: StabilityMap) -> dict[str, Any]:
    return {
        "x": _axis_dict(found.x),
        "y": None if found.y is None else _axis_dict(found.y),
        "growth": _numbers(found.growth),
        "damping": _numbers(found.damping),
        "boundary": [list(point) for point in found.boundary],
    }


def _axis_dict(axis: Axis) -> dict[str, Any]:
    return {"label": axis.label, "values": axis.values.tolist(), "own": axis.own}


def _numbers(table: NDArray[np.float64]) -> list[list[float | None]]:
    return [[float(value) if np.isfinite(value) else None for value in row] for row in table]


def _map_lines(answer: dict[str, Any]) -> list[str]:
    y = answer["y"]
    rows = [f"boundary of stability: {answer['x']['label']}" + ("" if y is None else f", {y['label']}")]
    for point in answer["boundary"]:
        shown = point if y is not None else point[:1]
        rows.append("  " + "".join(f"{value:>14.6g}" for value in shown))
    if not answer["boundary"]:
        rows.append("  none within the range")
    return [*rows, f"  {answer['plot']}"]


def _zeros(linearisation: Linearisation, experiment: Experiment, pair: str) -> list[dict[str, Any]]:
    coupled = linearisation.coupled()
    source, colon, signal = pair.partition(":")
    wires = {w.target.name: w for w in coupled.wires}
    outputs = [name for part in coupled.parts.values() for name in part.outputs]
    faults = [] if colon else [f"--zeros: not a pair, got {pair!r}, expected INPUT:OUTPUT"]
    if colon and source not in wires:
        faults.append(f"--zeros: no such connected input, got {source!r}, {expected(source, wires)}")
    if colon and signal not in outputs:
        faults.append(f"--zeros: no such connected output, got {signal!r}, {expected(signal, outputs)}")
    if colon and coupled.period != 1:
        faults.append("--zeros: FMUs of several rates, expected every FMU to step each tick")
    if faults:
        raise ConfigError(faults)
    return [pole_dict(z) for z in zeros(coupled, wires[source], signal)]
