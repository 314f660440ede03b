"""The whole: runs, figures, claims, files."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from master.errors import ConfigError, Problem, nearest
from master.pages.picture import save
from master.reproduce.claims.claim import Claim, Row, changed_verdicts, judge, wishes
from master.reproduce.figures.figure import Figure
from master.reproduce.figures.registry import FIGURES
from master.reproduce.measures.pool import Recordings, build_fmus, merged, perform_all

from .claims import identification, loop, methods
from .facts import orders
from .page import Content, write_page

CLAIMS: tuple[Claim, ...] = (
    *loop.CLAIMS,
    *methods.CLAIMS,
    *identification.CLAIMS,
)
_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")

Stage = Callable[[str, int], Callable[[int], None]]


@dataclass(frozen=True)
class Reproduction:
    """Judged rows, those among them that were judged otherwise when their claims were written, and files."""

    rows: Sequence[Row]
    changed: Sequence[str]
    files: dict[str, Any]

    def as_dict(self) -> dict[str, Any]:
        """Fields for JSON."""
        claims = [row.as_dict() for row in self.rows]
        return {"claims": claims, "changed": list(self.changed), "files": self.files}


def reproduce(
    folder: Path, stage: Stage, say: Callable[[str], None], only: Sequence[str] = ()
) -> Reproduction:
    """
    Reproduce the paper, or some of it.

    Args:
        folder: Where the page, the PNG files and claims.json go.
        stage: Begins a stage by name and number of parts; returns what counts the parts done.
        say: Shows that an FMU is built.
        only: Names of claims and numbers of figures; all where there are none.

    Raises:
        ConfigError: With each name that is neither.
    """
    claims, figures = _chosen(only)
    wanted = merged([wishes(claims), *(figure.wishes for figure in figures)])
    build_fmus(wanted, say)
    with _one_thread_each():
        recordings = perform_all(wanted, stage("runs of the FMUs", len(wanted)))
    judged = [(claim, judge(claim, recordings)) for claim in claims]
    drawing = stage("figures", len(figures) + 1)
    charts = {}
    (folder / "figures").mkdir(parents=True, exist_ok=True)
    pictures = {}
    for figure in figures:
        charts[figure.id] = figure.draw(recordings)
        pictures[figure.id] = str(save(_title(figure), charts[figure.id], folder / "figures" / _name(figure)))
        drawing(1)
    content = Content(charts, judged, orders.compare())
    drawing(1)
    rows = [row for _, rows in judged for row in rows]
    files = {"page": str(write_page(content, folder / "index.html")), "figures": pictures}
    files["claims"] = str(_write_claims(rows, folder / "claims.json"))
    changed = [text for claim, own in judged for text in changed_verdicts(claim, own)]
    return Reproduction(rows, changed, files)


def _chosen(only: Sequence[str]) -> tuple[Sequence[Claim], Sequence[Figure]]:
    if not only:
        return CLAIMS, FIGURES
    known = [*(claim.id for claim in CLAIMS), *(figure.id for figure in FIGURES)]
    unknown = [name for name in only if name not in known]
    if unknown:
        raise ConfigError(
            Problem("neither a claim nor a figure", where="--only", got=name, expected=nearest(name, known))
            for name in unknown
        )
    return [c for c in CLAIMS if c.id in only], [f for f in FIGURES if f.id in only]


def _write_claims(rows: Sequence[Row], path: Path) -> Path:
    path.write_text(json.dumps([row.as_dict() for row in rows], indent=2) + "\n", encoding="utf-8")
    return path


def _title(figure: Figure) -> str:
    return f"Fig. {figure.id}. {figure.title}" if figure.id.isdigit() else figure.title


def _name(figure: Figure) -> str:
    return f"fig_{figure.id}.png"


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Let each process of the pool compute with one thread: more than processors only hinder one another."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


__all__ = ["CLAIMS", "Recordings", "Reproduction", "reproduce"]
