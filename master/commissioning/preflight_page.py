"""The page of a pre-flight: the sentence for each method, maps over two unknowns, curves along one."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from master.pages.chart import CIRCLE, Chart, Curve
from master.pages.render import render

from .box import Box
from .preflight import Plant, Preflight, factors_text

SHADES = (0.0, 1e-3, 2e-3, 5e-3, 1e-2)
"""Damping ratios between the shades of a map."""


@dataclass(frozen=True)
class Field:
    """A field of a map: text, shade from 0 (well damped) to 5 (grows)."""

    text: str
    shade: int


@dataclass(frozen=True)
class Map:
    """Least damping over two unknowns, whatever the others are."""

    across: str
    down: str
    columns: Sequence[str]
    rows: Sequence[tuple[str, Sequence[Field]]]


def write_page(title: str, box: Box, found: Sequence[Preflight], path: Path) -> None:
    """Write the page."""
    charts = {f"method{i}": _charts(one, box) for i, one in enumerate(found)}
    text = render(
        "master.commissioning",
        "preflight.html.j2",
        heading=title,
        box=[_unknown(name, unknown) for name, unknown in box.box.items()],
        n_plants=box.n_plants,
        rows=[_row(one) for one in found],
        methods=[(f"method{i}", one, _maps(one, box)) for i, one in enumerate(found)],
        charts=charts,
        factors_text=factors_text,
        assumptions=list(
            dict.fromkeys((a.signal, str(a.value), a.reason) for p in found for a in p.assumptions)
        ),
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def milliseconds(value: float | None) -> str:
    """Show a time in ms; a dash where there is none."""
    return "-" if value is None else f"{1e3 * value:.2f}"


def _unknown(name: str, unknown: Any) -> list[str]:
    acts = [*unknown.multiplies, *(f"1/{signal}" for signal in unknown.divides)]
    return [name, f"{unknown.from_:g}", f"{unknown.to:g}", ", ".join(acts)]


def _row(one: Preflight) -> list[str]:
    worst, nominal = one.worst, one.nominal
    return [
        one.method,
        f"{nominal.zeta:+.5f}",
        f"{nominal.frequency:.4f}",
        milliseconds(nominal.later),
        f"{worst.zeta:+.5f}",
        factors_text(worst.factors),
        milliseconds(one.latency),
        milliseconds(one.closed_form),
    ]


def _maps(one: Preflight, box: Box) -> list[Map]:
    """One map for each pair of unknowns; a single unknown has none."""
    found = []
    for across, down in itertools.combinations(box.box, 2):
        columns = [float(v) for v in box.box[across].values(box.points)]
        rows = [float(v) for v in box.box[down].values(box.points)]
        fields = [
            (f"{row:.4g}", [_field(one.plants, {across: column, down: row}) for column in columns])
            for row in rows
        ]
        found.append(Map(across, down, [f"{c:.4g}" for c in columns], fields))
    return found


def _field(plants: Sequence[Plant], at: dict[str, float]) -> Field:
    zeta = _least(plants, at)
    return Field(f"{zeta:+.5f}", sum(zeta <= bound for bound in SHADES))


def _least(plants: Sequence[Plant], at: dict[str, float]) -> float:
    return min(p.zeta for p in plants if all(p.factors[name] == value for name, value in at.items()))


def _charts(one: Preflight, box: Box) -> list[Chart]:
    """Least damping along each unknown, whatever the others are, and that of the nominal plant."""
    found = []
    for name, unknown in box.box.items():
        factors = unknown.values(box.points)
        least = np.array([_least(one.plants, {name: float(factor)}) for factor in factors])
        curves = [
            Curve("worst of the others", factors, least),
            Curve("nominal", np.array([1.0]), np.array([one.nominal.zeta]), CIRCLE),
        ]
        found.append(
            Chart(f"{one.method}: {name}", f"factor on {name} [1]", "least damping ratio [1]", curves)
        )
    return found
