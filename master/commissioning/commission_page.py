"""The page of a commissioning: values with deviations, warnings, record and responses."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from master.pages.chart import CIRCLE, REFERENCE, Chart, Curve, decimated
from master.pages.render import render

from .commission import Commissioned
from .fit import Fit
from .rig import Held


def write_page(
    title: str, method: str, held: Held, found: Commissioned, told: dict[str, float], path: Path
) -> None:
    """Write the page."""
    t = np.asarray(held.period * np.arange(len(held.s_cmd)), dtype=np.float64)
    motions = [Curve("s_cmd", t, 1e3 * held.s_cmd, REFERENCE), Curve("s_act", t, 1e3 * held.s_act)]
    record = [
        Chart("Motion", "time [s]", "displacement [mm]", [decimated(curve) for curve in motions]),
        Chart("Force", "time [s]", "measured force [N]", [decimated(Curve("f_mea", t, held.f_mea))]),
    ]
    responses = [
        *_response("s_cmd to s_act", found.plant, "1"),
        *_response("s_act to f_mea", found.contact, "N/m"),
    ]
    text = render(
        "master.commissioning",
        "commission.html.j2",
        heading=title,
        method=method,
        warnings=found.warnings,
        values=[[v.name, f"{v.value:.6g}", f"{v.deviation:.2g}", v.unit, v.meaning] for v in found.values],
        fits=[
            [
                "s_cmd to s_act",
                f"{found.plant.rms:.3g}",
                f"{found.plant.noise:.3g}",
                "m",
                f"{found.plant.ratio:.2f}",
            ],
            [
                "s_act to f_mea",
                f"{found.contact.rms:.3g}",
                f"{found.contact.noise:.3g}",
                "N",
                f"{found.contact.ratio:.2f}",
            ],
        ],
        told=[[name, f"{value:.6g}"] for name, value in told.items()],
        charts={"record": record, "responses": responses},
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def _response(name: str, found: Fit, unit: str) -> list[Chart]:
    f = found.frequency
    size = [Curve("measured", f, np.abs(found.measured), CIRCLE), Curve("fitted", f, np.abs(found.fitted))]
    phase = [
        Curve("measured", f, np.degrees(np.unwrap(np.angle(found.measured))), CIRCLE),
        Curve("fitted", f, np.degrees(np.unwrap(np.angle(found.fitted)))),
    ]
    return [
        Chart(f"{name}: size", "frequency [Hz]", f"size [{unit}]", size, logarithmic=True),
        Chart(f"{name}: phase", "frequency [Hz]", "phase [deg]", phase),
    ]
