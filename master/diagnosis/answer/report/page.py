"""One HTML file with everything: verdict, tables, panels; nothing is fetched."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fmu_sources.effects.catalogue import effect
from master.pages.render import render

from . import tables
from .panels import Panel
from .spoken import first_sentence, laws

Units = Mapping[str, str]


@dataclass(frozen=True)
class _Gain:
    """Errors of one signal on the sealed part: RMSE in its unit, and relative to what was measured."""

    signal: str
    unit: str
    before: float
    after: float
    before_percent: float
    after_percent: float


def page(report: Mapping[str, Any], panels: Sequence[Panel], units: Units) -> str:
    """
    Write the page of a report.

    Args:
        report: What `report.json` holds.
        panels: Charts and pictures that were drawn.
        units: Name of the unit of each variable `fmu.name`.
    """
    drawn = {panel.file.stem: panel.charts for panel in panels if panel.file and panel.charts}
    return render(
        __package__ or "",
        "diagnosis.html.j2",
        report=report,
        spoken=first_sentence(report, units),
        laws=laws(report, units),
        gains=list(_gains(report, units)),
        errors=tables.errors(report, units),
        parameters=tables.parameters(report["parameters"], units),
        recordings=tables.recordings(report["recordings"]),
        runners_up=tables.runners_up(report["runners_up"]),
        residuals=tables.residuals(report["residual"]),
        channels=tables.channels(report["channels"], units),
        descriptions={e["effect"]: effect(e["effect"]).description for e in report["effects"]},
        panels=panels,
        charts=drawn,
        pictures={panel.file: _as_address(panel.file) for panel in panels if panel.file},
    )


def _as_address(picture: Path) -> str:
    """Return a PNG file as the address of an image in the page."""
    return f"data:image/png;base64,{base64.b64encode(picture.read_bytes()).decode()}"


def _gains(report: Mapping[str, Any], units: Units) -> Iterator[_Gain]:
    """Yield the signals whose error an effect has changed."""
    for signal, before in report["before"].items():
        after = report["after"][signal]
        if report["effects"] and None not in (before["rmse"], after["rmse"]) and before != after:
            yield _Gain(
                signal=signal,
                unit=units.get(signal, ""),
                before=before["rmse"],
                after=after["rmse"],
                before_percent=before["nrmse_percent"],
                after_percent=after["nrmse_percent"],
            )
