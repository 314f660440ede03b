"""`dockloop design-dpdc`: the phase lead for a system, from its plant and its range of frequencies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np

from ..analysis.phase_lead_design import Design, design
from ..errors import ConfigError
from ..experiment import Request, prepare
from .common import CONFIG, FLAVOUR, JSON, SET, VARIANT, answers_errors, print_json, show_building


@click.command("design-dpdc")
@CONFIG
@VARIANT
@SET
@click.option(
    "--range",
    "spans",
    multiple=True,
    metavar="ATTRIBUTE=LEAST:LARGEST",
    help="Range of m_s [kg], m_e [kg], k_m or k_p [N/m].",
)
@FLAVOUR
@JSON
@answers_errors
def design_dpdc(config: Path, spans: tuple[str, ...], as_json: bool, **options: Any) -> None:
    """Design the displacement phase delay compensation of CONFIG: alpha, T, K, and the phase left."""
    experiment = prepare(config, Request(**options), show_building)
    wanted = experiment.config.dpdc
    fmu = "compensator" if wanted is None else wanted.fmu
    ranges = {} if wanted is None else {str(key): span for key, span in wanted.ranges.items()}
    found = design(experiment, fmu, ranges | dict(_span(text) for text in spans))
    if as_json:
        print_json({"name": experiment.config.name, "fmu": fmu, **found.as_dict()})
        return
    click.echo("\n".join([f"{experiment.config.name}: phase lead of {fmu}", *_lines(found)]))


def _span(text: str) -> tuple[str, tuple[float, float]]:
    name, _, span = text.partition("=")
    try:
        least, largest = (float(value) for value in span.split(":"))
    except ValueError:
        raise ConfigError([f"--range: not a range, got {text!r}, expected attribute=least:largest"]) from None
    return name, (least, largest)


def _lines(found: Design) -> list[str]:
    rows = [
        f"  alpha {found.alpha:.4f}, T {found.time_constant:.4f} s, K {found.gain:.4f}",
        f"  dpdc_phase: {found.phase:.5f}, dpdc_frequency: {found.frequency:.4f}",
        f"  {'f [Hz]':>8}{'lag [deg]':>11}{'left [deg]':>12}{'magnitude':>11}",
    ]
    table = zip(
        found.frequencies, np.degrees(found.lag), np.degrees(found.left), found.magnitude, strict=True
    )
    return rows + [f"  {f:>8.4f}{lag:>11.3f}{left:>12.3f}{size:>11.4f}" for f, lag, left, size in table]
