"""The page of a campaign: how often it goes wrong, its numbers and what they depend on, the worst runs."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from master.pages.chart import Chart, Curve
from master.pages.palette import LIGHT
from master.pages.render import number, render
from master.recording.whole_file import write_whole
from master.stepping.outcome import COMPLETED, DIVERGED
from master.text.yaml_lines import write_yaml

from .dataset import read_columns
from .interval import Interval, probability
from .plan import DIVERGED_SHARE, Plan
from .sensitivity import sobol_indices, tornado
from .stability import stability
from .stepper import FAILURES
from .swept import Swept
from .systems import portable

Floats = NDArray[np.float64]
Columns = Mapping[str, NDArray[Any]]

GROWTH = "growth_per_cycle"  # a metric of runs that compare motions
WORST = 10
MOST_CHARTS = 12
MOST_POINTS = 1500  # of a scatter plot
MOST_SCATTERED = 5  # inputs and numbers of the scatter matrix, each
_BINS = 40
_QUANTILES = (0.05, 0.5, 0.95)


@dataclass(frozen=True)
class Worst:
    """One of the worst runs: what it was, and the command that repeats it."""

    run: int
    status: str
    said: str
    command: str


def answers(plan: Plan, columns: Columns) -> dict[str, Any]:
    """Return the answers of a campaign as numbers, by what they are."""
    diverged = diverged_share(columns)
    growing = growing_share(columns)
    values = {DIVERGED_SHARE: _diverged(columns), **{name: columns[name] for name in plan.numbers}}
    found: dict[str, Any] = {
        "diverged": None if diverged is None else diverged.__dict__,
        "growing": None if growing is None else growing.__dict__,
        "numbers": {name: _described(columns[name]) for name in plan.numbers},
    }
    if plan.campaign.design.method == "saltelli" and len(columns["run"]) == plan.sample.n_runs:
        keys = [column.key for column in plan.sample.free]
        found["sobol"] = {
            name: {
                index.key: {"first": index.first.__dict__, "total": index.total.__dict__}
                for index in sobol_indices(keys, numbers.astype(float))
            }
            for name, numbers in values.items()
        }
    return found


def diverged_share(columns: Columns) -> Interval | None:
    """Return the share of runs that diverged, of those that did not fail, with its interval of 95 %."""
    known = _diverged(columns)
    known = known[np.isfinite(known)]
    return probability(int(known.sum()), len(known)) if len(known) else None


def growing_share(columns: Columns) -> Interval | None:
    """
    Return the share of runs that grew from cycle to cycle, of those to the end whose motion has a growth.

    A run that has not reached a limit when it ends has not diverged, but it may be on its way.
    """
    if GROWTH not in columns:
        return None
    growth = columns[GROWTH][columns["status"] == COMPLETED].astype(float)
    growth = growth[np.isfinite(growth)]
    return probability(int((growth > 1.0).sum()), len(growth)) if len(growth) else None


def write_page(plan: Plan, swept: Swept, folder: Path, path: Path) -> Path:
    """
    Write the page, and the systems of the worst runs whose structure varies, into the folder.

    Raises:
        OSError: If it cannot be written.
    """
    inputs = [column.key for column in plan.sample.columns if column.key != "seed"]
    columns = read_columns(folder / "runs", ["run", "status", "message", *inputs, *plan.numbers])
    known = answers(plan, columns)
    judged = _judged(plan)
    numbers = [name for name in plan.numbers if np.isfinite(columns[name]).any()]
    numeric = {
        c.key: columns[c.key].astype(float) for c in plan.sample.columns if c.key in inputs and c.is_number
    }
    dependent = {name: columns[name].astype(float) for name in numbers}
    with_diverged = {DIVERGED_SHARE: _diverged(columns), **dependent}
    maps = stability(plan, columns)
    charts = {"histograms": [_histogram(plan, name, columns[name]) for name in numbers[:MOST_CHARTS]]}
    if maps is not None:
        charts["stability"] = maps.charts
    text = render(
        "master.campaign",
        "campaign.html.j2",
        plan=plan,
        swept=swept,
        share=diverged_share(columns),
        growing=growing_share(columns),
        inputs=[[c.key, plan.campaign.vary[c.key].kind, c.unit] for c in plan.sample.columns],
        numbers=_number_rows(plan, known["numbers"]),
        charts=charts,
        stability=maps,
        scatter=_scatter(plan, numeric, dependent),
        tornadoes=[
            (name, [[bar.key, number(bar.low), number(bar.high), number(bar.span)] for bar in bars])
            for name, bars in ((name, tornado(numeric, values)) for name, values in with_diverged.items())
            if bars and bars[0].span > 0.0
        ],
        sobol=_sobol_rows(known.get("sobol", {})),
        judged=judged,
        worst=_worst(plan, columns, judged, folder),
    )
    write_whole(path, text)
    return path


def _judged(plan: Plan) -> str | None:
    """Name the number by which runs are the worst: that of `until`, else the first one of an error."""
    until = plan.campaign.until
    if until is not None and until.measure in plan.numbers:
        return until.measure
    preferred = ("rms_s_act", "rms_s_des")
    found = [name for name in (*preferred, *plan.measures, *plan.metrics) if name in plan.numbers]
    return found[0] if found else None


def _diverged(columns: Columns) -> Floats:
    """Return 1 for a run that diverged, 0 for another, NaN for one that failed; shape (runs,)."""
    status = columns["status"].astype(str)
    return np.where(np.isin(status, FAILURES), np.nan, (status == DIVERGED).astype(float))


def _described(values: NDArray[Any]) -> dict[str, float | int | None]:
    known = values[np.isfinite(values.astype(float))].astype(float)
    if len(known) == 0:
        return {"n": 0}
    low, median, high = np.quantile(known, _QUANTILES)
    return {
        "n": len(known),
        "mean": float(np.mean(known)),
        "deviation": float(np.std(known, ddof=1)) if len(known) > 1 else None,
        "minimum": float(np.min(known)),
        "q05": float(low),
        "median": float(median),
        "q95": float(high),
        "maximum": float(np.max(known)),
    }


def _number_rows(plan: Plan, described: Mapping[str, Mapping[str, float | None]]) -> list[list[str]]:
    keys = ("mean", "deviation", "minimum", "q05", "median", "q95", "maximum")
    return [
        [name, plan.units[name], str(found["n"]), *(number(found.get(key)) for key in keys)]
        for name, found in described.items()
    ]


def _histogram(plan: Plan, name: str, values: NDArray[Any]) -> Chart:
    """Draw the runs in bins between the 0.5 % and the 99.5 % quantile, as steps."""
    known = values[np.isfinite(values.astype(float))].astype(float)
    low, high = np.quantile(known, [0.005, 0.995])
    if not high > low:
        low -= 0.5
        high += 0.5
    counts, edges = np.histogram(known, bins=_BINS, range=(low, high))
    x = np.repeat(edges, 2)[1:-1]
    unit = plan.units[name]
    label = name if unit == "1" else f"{name} [{unit}]"
    steps = x + 1e-9 * (high - low) * np.tile([0.0, 1.0], len(x) // 2)  # abscissas ascend
    return Chart("", label, "runs", [Curve(name, steps, np.repeat(counts, 2).astype(float))])


def _scatter(plan: Plan, inputs: Mapping[str, Floats], numbers: Mapping[str, Floats]) -> str | None:
    """Draw numbers over inputs, one small picture each, as the address of an image; None without either."""
    rows = list(numbers)[:MOST_SCATTERED]
    across = list(inputs)[:MOST_SCATTERED]
    if not rows or not across:
        return None
    from matplotlib.figure import Figure

    n = len(inputs[across[0]])
    chosen = (
        np.arange(n) if n <= MOST_POINTS else np.random.default_rng(1).choice(n, MOST_POINTS, replace=False)
    )
    figure = Figure(figsize=(1.2 + 2.0 * len(across), 0.8 + 1.5 * len(rows)), layout="constrained")
    axes = figure.subplots(len(rows), len(across), sharex="col", sharey="row", squeeze=False)
    for i, name in enumerate(rows):
        for j, key in enumerate(across):
            axis = axes[i][j]
            axis.plot(inputs[key][chosen], numbers[name][chosen], ".", markersize=1.5, color=LIGHT[0])
            axis.tick_params(labelsize=6)
            if j == 0:
                axis.set_ylabel(name, fontsize=7)
            if i == len(rows) - 1:
                axis.set_xlabel(f"{key} [{plan.units[key]}]", fontsize=7)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=130, metadata={"Software": None})
    return f"data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}"


def _sobol_rows(found: Mapping[str, Any]) -> list[tuple[str, list[list[str]]]]:
    def shown(interval: Mapping[str, float]) -> str:
        return f"{interval['value']:.3f} ({interval['low']:.3f} to {interval['high']:.3f})"

    return [
        (name, [[key, shown(index["first"]), shown(index["total"])] for key, index in indices.items()])
        for name, indices in found.items()
        if any(np.isfinite(index["total"]["value"]) for index in indices.values())
    ]


def _worst(plan: Plan, columns: Columns, judged: str | None, folder: Path) -> list[Worst]:
    """List failed runs, then diverged ones, then those with the largest number."""
    status = columns["status"].astype(str)
    rank = np.where(np.isin(status, FAILURES), 2, np.where(status == DIVERGED, 1, 0))
    values = (
        np.zeros(len(status)) if judged is None else np.nan_to_num(columns[judged].astype(float), nan=-np.inf)
    )
    order = np.lexsort((-values, -rank))[:WORST]
    found: list[Worst] = []
    for i in order.tolist():
        run = int(columns["run"][i])
        file = folder / "worst" / f"run-{run}.yaml"
        if plan.needs_file(run):
            document = plan.varied.document(plan.values(run))
            write_whole(file, write_yaml(portable(document)))
        said = str(columns["message"][i])
        if judged is not None:
            said = "; ".join(filter(None, [f"{judged} {number(float(columns[judged][i]))}", said]))
        found.append(Worst(run, str(status[i]), said, plan.command(run, str(file))))
    return found
