"""`dockloop design-dpdc`: the phase lead for a system, from its plant and its range of frequencies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np

from master.docking.phase_lead import Design, design
from master.errors import ConfigError, expected
from master.experiment.phase_lead import ATTRIBUTES
from master.experiment.prepare import Request, prepare
from master.system.config import PhaseLead

from .common import (
    CONFIG,
    FLAVOUR,
    JSON,
    SET,
    STEP_SIZE,
    VARIANT,
    answers_errors,
    calls_fmus,
    print_json,
    say,
    show_building,
)


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
@click.option(
    "--amplitude",
    type=click.Choice(["paper", "plant"]),
    help="Gain of the lead at its frequency: 1 (paper), or what undoes the plant's attenuation.",
)
@STEP_SIZE
@FLAVOUR
@JSON
@answers_errors
@calls_fmus
def design_dpdc(
    config: Path, spans: tuple[str, ...], amplitude: str | None, as_json: bool, **options: Any
) -> None:
    """Design the displacement phase delay compensation of CONFIG: alpha, T, K, and what it leaves."""
    experiment = prepare(config, Request(**options), show_building)
    wanted = experiment.phase_lead or PhaseLead(design="auto")
    ranges = {str(key): span for key, span in wanted.ranges.items()} | dict(map(_span, spans))
    amplitude = amplitude or wanted.amplitude
    found = design(experiment, wanted.model_copy(update={"ranges": ranges, "amplitude": amplitude}))
    if as_json:
        about = {"name": experiment.name, "fmu": wanted.fmu, "amplitude": amplitude}
        print_json(about | found.as_dict())
        return
    say("\n".join([f"{experiment.name}: phase lead of {wanted.fmu}", *_lines(found)]))


def _span(text: str) -> tuple[str, tuple[float, float]]:
    name, _, span = text.partition("=")
    if name not in ATTRIBUTES:
        raise ConfigError([f"--range: no such attribute, got {name!r}, {expected(name, ATTRIBUTES)}"])
    try:
        least, largest = (float(value) for value in span.split(":"))
    except ValueError:
        raise ConfigError([f"--range: not a range, got {text!r}, expected attribute=least:largest"]) from None
    return name, (least, largest)


def _lines(found: Design) -> list[str]:
    rows = [
        f"  alpha {found.alpha:.4f}, T {found.time_constant:.4f} s, K {found.gain_at_rest:.4f}",
        f"  dpdc_phase: {found.phase:.5f}, dpdc_frequency: {found.frequency:.4f}, "
        f"dpdc_gain: {found.gain:.4f}",
        f"  {'':>8}{'without DPDC':>22}{'with DPDC':>22}",
        f"  {'f [Hz]':>8}{'lag [deg]':>11}{'amplitude':>11}{'lag [deg]':>11}{'amplitude':>11}",
    ]
    columns = np.degrees(found.lag), np.abs(found.plain), np.degrees(found.left), np.abs(found.led)
    table = zip(found.frequencies, *columns, strict=True)
    return rows + ["  {:>8.4f}{:>11.3f}{:>11.4f}{:>11.3f}{:>11.4f}".format(*row) for row in table]
