"""The nominal model of a case over its recordings as a picture, before anything is fitted."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from master.errors import DataError
from master.pages.chart import REFERENCE, Chart, Curve
from master.pages.picture import save
from master.recording.folder import reason

from .replayed import Replayed, replay

_TIME = "time [s], recordings one after the other"


def draw_nominal(case: Path, path: Path) -> Path:
    """
    Replay the models of a case as they are, and draw them over what was measured; sealed rows are left out.

    Raises:
        ConfigError: With every fault of the case.
        DataError: If the picture cannot be written.
        FmuError: If an FMU fails.
    """
    charts = [chart for part in replay(case).values() for chart in nominal_charts(part)]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return save(f"{case.name}: the model as it is, sealed rows left out", charts, path)
    except OSError as error:
        raise DataError(f"{path}: cannot be written: {reason(error)}") from None


def nominal_charts(part: Replayed) -> list[Chart]:
    """Return two charts a compared signal, in SI units: measured and simulated, and what is left."""
    open_rows = np.ones(len(part.t), dtype=bool)
    open_rows[part.sealed] = False
    measured = np.where(open_rows[:, None], part.measured, np.nan)
    predicted = np.where(open_rows[:, None], part.predicted, np.nan)
    charts = []
    for i, name in enumerate(part.part.compared):
        curves = [
            Curve("measured", part.t, measured[:, i], REFERENCE),
            Curve("the model as it is", part.t, predicted[:, i]),
        ]
        left = Curve("measured less the model", part.t, measured[:, i] - predicted[:, i])
        charts += [Chart(name, _TIME, "[SI]", curves), Chart(f"{name}: residual", _TIME, "[SI]", [left])]
    return charts
