"""
Stability over two varied values: as the runs grew, and as the eigenvalues of the tick say.

Both are growth [1/s] on the same cells, those of quantiles of the two values, so that each has as many runs.
Runs: median of ln(growth per cycle) times the frequency over the runs of a cell, whatever else varied.
Eigenvalues: the fastest pole at the medians of the cell, all other values at their medians, adaptation frozen
and the reference left out, which is in no loop. Neutral poles, z = 1, are no growth.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from master.analysis.closed_loop.linearise import Linearisation, without_reference
from master.analysis.measures.map_chart import map_chart
from master.analysis.measures.poles import fastest
from master.analysis.measures.sweep import Axis, StabilityMap
from master.errors import ConfigError, FmuError
from master.pages.chart import Chart
from master.text.signal_name import SignalName

from .plan import Plan
from .sensitivity import tornado
from .stepper import CRASHED, TIMED_OUT
from .systems import Systems
from .target import SEED

Floats = NDArray[np.float64]
Columns = Mapping[str, NDArray[Any]]

NEEDED = ("growth_per_cycle", "frequency", "zeta")
"""Metrics that the growth of a run is known from."""

_MOST_CELLS = 10  # along each axis
_FEWEST_CELLS = 3
_RUNS_IN_A_CELL = 10  # on the average
_NEUTRAL = 1e-7  # distance of a pole from z = 1


@dataclass(frozen=True)
class Stability:
    """Two maps over the same values; `note` says why the second is missing, or what it takes for granted."""

    charts: list[Chart]
    note: str


@dataclass(frozen=True)
class _Cells:
    """Cells of two values: which cell each run is in, and the medians along each axis."""

    keys: tuple[str, str]
    places: NDArray[np.int64]
    medians: tuple[Floats, Floats]

    @property
    def n(self) -> int:
        """Number of cells along an axis."""
        return len(self.medians[0])

    def median(self, values: Floats) -> Floats:
        """Median over the runs of each cell, shape (second value, first value)."""
        order = np.argsort(self.places, kind="stable")
        ends = np.cumsum(np.bincount(self.places, minlength=self.n * self.n))[:-1]
        found = [np.median(part) for part in np.split(values[order], ends)]
        return np.array(found).reshape(self.n, self.n)


def stability(plan: Plan, columns: Columns) -> Stability | None:
    """
    Draw both maps over the two values that the growth depends on most.

    None where runs have no growth, fewer than two numbers of FMUs vary, or the runs leave cells empty.
    """
    if any(name not in columns for name in NEEDED):
        return None
    factor, frequency, zeta = (columns[name].astype(float) for name in NEEDED)
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.log(factor) * frequency
    known = np.isfinite(rate) & np.isfinite(zeta)
    inputs = {
        column.key: columns[column.key].astype(float)
        for column in plan.sample.free
        if column.is_number and not column.target.is_structural and SignalName(column.key).variable != SEED
    }
    bars = tornado(inputs, np.where(known, rate, np.nan))
    if len(bars) < 2:
        return None
    keys = (bars[0].key, bars[1].key)
    cells = _cells(keys, inputs[keys[0]][known], inputs[keys[1]][known])
    if cells is None:
        return None
    of_runs = _map(plan, cells, cells.median(rate[known]), cells.median(zeta[known]))
    charts = [map_chart(of_runs, "from the runs")]
    if np.isin(columns["status"].astype(str), (CRASHED, TIMED_OUT)).any():
        return Stability(charts, "No eigenvalues: an FMU of this campaign ends its process or hangs.")
    try:
        of_poles, note = _of_poles(plan, cells)
    except (ConfigError, FmuError) as error:
        return Stability(charts, f"No eigenvalues: {error}.")
    return Stability([*charts, map_chart(of_poles, "from eigenvalues")], note)


def _cells(keys: tuple[str, str], x: Floats, y: Floats) -> _Cells | None:
    """Cut two values at quantiles into as many cells as leave none empty."""
    n = min(_MOST_CELLS, int(np.sqrt(len(x) / _RUNS_IN_A_CELL)))
    for size in range(n, _FEWEST_CELLS - 1, -1):
        across, down = (_places(values, size) for values in (x, y))
        places = down * size + across
        if len(np.unique(places)) == size * size:
            medians = tuple(
                np.array([np.median(values[own == i]) for i in range(size)])
                for values, own in ((x, across), (y, down))
            )
            if all(np.all(np.diff(found) > 0.0) for found in medians):
                return _Cells(keys, places, (medians[0], medians[1]))
    return None


def _places(values: Floats, n: int) -> NDArray[np.int64]:
    edges = np.quantile(values, np.linspace(0.0, 1.0, n + 1)[1:-1])
    return np.searchsorted(edges, values, side="right").astype(np.int64)


def _map(plan: Plan, cells: _Cells, growth: Floats, damping: Floats) -> StabilityMap:
    x, y = (
        Axis((key,), values, plan.units[key], None)
        for key, values in zip(cells.keys, cells.medians, strict=True)
    )
    return StabilityMap(x, y, growth, damping, ())


def _of_poles(plan: Plan, cells: _Cells) -> tuple[StabilityMap, str]:
    """
    Compute the fastest pole in each cell.

    Raises:
        ConfigError, FmuError: If there is none.
    """
    across, down = cells.keys
    grid = plan.grid({across: cells.medians[0].tolist(), down: cells.medians[1].tolist()})
    base = Systems(plan.varied).experiment(grid.values(0))
    linearisation = Linearisation(without_reference(base))
    varying = {c.key for c in grid.columns if c.is_number and np.ptp(c.values.astype(float)) > 0.0}
    growth = np.empty((cells.n, cells.n))
    damping = np.empty_like(growth)
    for run in range(grid.n_runs):
        values = {key: value for key, value in grid.values(run).items() if key in varying}
        found = fastest(linearisation.coupled(plan.varied.settings(values)), neutral=_NEUTRAL)
        place = tuple(
            int(np.argmin(np.abs(medians - values[key])))
            for key, medians in ((down, cells.medians[1]), (across, cells.medians[0]))
        )
        growth[place] = found.growth
        damping[place] = found.zeta
    taken = "; ".join(f"{a.signal} = {a.value} ({a.reason})" for a in linearisation.assumptions)
    return _map(plan, cells, growth, damping), f"Eigenvalues take for granted: {taken}." if taken else ""
