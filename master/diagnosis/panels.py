"""Panels of a diagnosis as PNG: measured and simulated, the residual in time, spectrum and state plane."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.signal import welch

from fmu_sources.effects.learned import N_SPLINES

from .learning import coefficients
from .part_result import PartResult
from .pipeline import Diagnosis
from .sealed import SealedPart
from .tables import Array

MOST_POINTS = 4000
BEFORE, AFTER, MEASURED = "#c44e52", "#4c72b0", "#222222"


def panels(diagnosis: Diagnosis, sealed: Mapping[str, SealedPart], folder: Path) -> list[Path]:
    """Draw all panels into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for part in diagnosis.parts:
        name = part.study.bench.part.name.replace(" and ", "_")
        own = sealed[part.study.bench.part.name]
        files.append(_save(_compared(own), folder / f"{name}_sealed.png"))
        if not part.is_exact:
            files.append(_save(_residual(part, own), folder / f"{name}_residual.png"))
        if part.learned is not None and part.learned.extended.added == part.chosen.added:
            files.append(_save(_law(part), folder / f"{name}_learned.png"))
    return files


def _save(figure: Figure, path: Path) -> Path:
    FigureCanvasAgg(figure)
    figure.savefig(path, dpi=110)
    return path


def _compared(own: SealedPart) -> Figure:
    k = len(own.part.compared)
    figure = Figure((10.0, 2.6 * k + 0.6), layout="constrained")
    axes: Any = figure.subplots(k, 2, squeeze=False, sharex="col")
    every = max(1, len(own.t) // MOST_POINTS)
    for row, (name, i) in zip(axes, zip(own.part.compared, range(k), strict=True), strict=True):
        for values, colour, label in (
            (own.measured, MEASURED, "measured"),
            (own.before, BEFORE, "before"),
            (own.after, AFTER, "after"),
        ):
            row[0].plot(own.t[::every], values[::every, i], ".", ms=1.5, color=colour, label=label)
        for values, colour, label in ((own.before, BEFORE, "before"), (own.after, AFTER, "after")):
            row[1].plot(
                own.t[::every], (own.measured - values)[::every, i], ".", ms=1.5, color=colour, label=label
            )
        row[0].set_ylabel(name)
        row[1].set_ylabel("measured - simulated")
        for ax in row:
            ax.legend(loc="upper right", markerscale=5, fontsize=7)
            ax.set_xlabel("time [s]")
    return figure


def _residual(part: PartResult, own: SealedPart) -> Figure:
    figure = Figure((10.0, 6.4), layout="constrained")
    axes: Any = figure.subplots(2, 2)
    study = part.study
    worst = int(np.argmax(study.size / np.maximum(study.measured.std(axis=0), 1e-300)))
    rows = study.bench.in_use
    for fit, colour, label in ((part.base, BEFORE, "before"), (part.fit, AFTER, "after")):
        left = (study.measured - fit.predicted)[rows, worst]
        f, power = welch(left, 1.0 / study.bench.row_period, nperseg=min(2048, len(left)))
        axes[0, 0].loglog(f[1:], np.sqrt(power[1:]), color=colour, label=label)
    axes[0, 0].set(xlabel="frequency [Hz]", ylabel="residual / sqrt(Hz)", title="spectrum")
    axes[0, 0].legend()
    _correlations(axes[0, 1], part)
    _map(axes[1, 0], part, worst)
    _gains(axes[1, 1], part)
    return figure


def _correlations(ax: Any, part: PartResult) -> None:
    found = part.correlations[:8][::-1]
    ax.barh(
        [c.basis for c in found],
        [abs(c.value) for c in found],
        color=[AFTER if c.is_found else "0.7" for c in found],
    )
    ax.set(title="cross-correlations (blue: significant)")
    ax.tick_params(axis="y", labelsize=6)


def _map(ax: Any, part: PartResult, worst: int) -> None:
    """Residual over position and velocity of the slot of the effect, else of the first with both."""
    study = part.study
    wanted = [f"{a.fmu}.{a.slot}" for a in part.chosen.added]
    known = [s for s in (*wanted, *study.signals) if s in study.signals and len(study.signals[s]) > 1]
    if not known:
        ax.set_axis_off()
        return
    signals = study.signals[known[0]]
    roles = [r for r in ("position", "velocity", "value") if r in signals][:2]
    x, y = (study.bench.compared_rows(signals[r]) for r in roles)
    left = (study.measured - part.base.predicted)[:, worst]
    every = max(1, len(x) // MOST_POINTS)
    limit = float(np.nanpercentile(np.abs(left), 98)) or 1.0
    points = ax.scatter(x[::every], y[::every], c=left[::every], s=3, cmap="RdBu", vmin=-limit, vmax=limit)
    ax.figure.colorbar(points, ax=ax, label="residual before")
    ax.set(xlabel=roles[0], ylabel=roles[1], title=known[0])


def _gains(ax: Any, part: PartResult) -> None:
    rounds = part.found.rounds if part.found is not None else ()
    ranked = [(f"{i}. {r.name}", r.gain) for i, step in enumerate(rounds, start=1) for r in step.ranked[:5]][
        ::-1
    ]
    if not ranked:
        ax.set_axis_off()
        return
    ax.barh(
        [n for n, _ in ranked],
        [g.mean for _, g in ranked],
        xerr=[2 * g.error for _, g in ranked],
        color=AFTER,
    )
    ax.axvline(0.01, color="0.4", lw=0.8)
    ax.set(title="gain on held-out blocks, log of power")
    ax.tick_params(axis="y", labelsize=6)


def _law(part: PartResult) -> Figure:
    """The learned law as its coefficients: the value near the centre of each spline."""
    added = part.chosen.added[-1]
    values: Array = coefficients(added, part.fit)
    first, second = added.effect.removeprefix("learned_").split("_")
    figure = Figure((5.6, 4.4), layout="constrained")
    ax: Any = figure.subplots()
    limit = float(np.abs(values).max()) or 1.0
    image = ax.imshow(values.T, origin="lower", cmap="RdBu", vmin=-limit, vmax=limit, extent=(-1, 1, -1, 1))
    figure.colorbar(image, label=f"added to {added.slot}")
    ax.set(
        xlabel=f"{first} / half range",
        ylabel=f"{second} / half range",
        title=f"{N_SPLINES} x {N_SPLINES} splines",
    )
    return figure
