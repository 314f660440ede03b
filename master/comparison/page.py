"""The comparison as one HTML file: a heat map that is a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from master.pages.render import render

from .compare import Score

_SHADES = 5


@dataclass(frozen=True)
class Field:
    """What a cell of the heat map shows: text and shade, 0 (good) to 5 (bad)."""

    text: str
    shade: int


def shown(score: Score) -> str:
    """Return `s_des/s_act` in percent, or the status."""
    if score.s_des is None or score.s_act is None:
        return score.status
    return f"{score.s_des:.2f}/{score.s_act:.2f}"


def _shade(score: Score) -> int:
    """One shade a factor of four, from 0.1 % of the worse of the two."""
    if score.s_des is None or score.s_act is None:
        return _SHADES
    worse = max(score.s_des, score.s_act, 1e-9)
    return min(_SHADES, max(0, math.ceil(math.log(worse / 0.1, 4))))


def write_page(scores: Sequence[Score], n_seeds: int, path: Path) -> None:
    """Write the page."""
    methods = list(dict.fromkeys(s.method for s in scores))
    rows: dict[tuple[str, str], dict[str, Field]] = {}
    for score in scores:
        rows.setdefault((score.config, score.cell), {})[score.method] = Field(shown(score), _shade(score))
    text = render(
        "master.comparison",
        "comparison.html.j2",
        methods=methods,
        rows=[(config, cell, [fields[m] for m in methods]) for (config, cell), fields in rows.items()],
        n_seeds=n_seeds,
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
