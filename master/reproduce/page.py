"""The page: one HTML file with style, script and data inside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from master.pages.chart import Chart, decimated
from master.pages.render import number, render
from master.reproduce.claims.claim import CONDITION, FAILS, HOLDS, Claim, Row, overall
from master.reproduce.facts.cases import CASES
from master.reproduce.facts.errata import ERRATA
from master.reproduce.facts.orders import Ordered
from master.reproduce.facts.parameters import OPEN, PARAMETERS
from master.reproduce.figures.figure import Figure
from master.reproduce.figures.registry import FIGURES, PAPER

_CLASSES = {HOLDS: "holds", CONDITION: "condition", FAILS: "fails"}


@dataclass(frozen=True)
class Content:
    """All that the page shows: charts by figure, rows by claim, orders."""

    charts: Mapping[str, Sequence[Chart]]
    judged: Sequence[tuple[Claim, Sequence[Row]]]
    orders: Sequence[Ordered]


@dataclass(frozen=True)
class _ShownRow:
    """A row as it is shown: its case, and of bound and reason what is not that of the claim."""

    case: str
    bound: str
    bound_from: str
    measured: float | None
    noise: str
    is_noiseless: bool
    verdict: str
    why: str


@dataclass(frozen=True)
class _ShownClaim:
    """A claim as it is shown, with its rows and the verdict on it as a whole."""

    id: str
    text: str
    place: str
    why: str
    bound_from: str
    verdict: str
    counts: str
    rows: Sequence[_ShownRow]


def write_page(content: Content, path: Path) -> Path:
    """Write the page."""
    rows = [row for _, judged in content.judged for row in judged]
    figures = [figure for figure in FIGURES if figure.id in content.charts]
    text = render(
        "master.reproduce",
        "reproduction.html.j2",
        charts={name: [_thinned(chart) for chart in charts] for name, charts in content.charts.items()},
        figures=figures,
        titles={figure.id: _title(figure) for figure in figures},
        classes=_CLASSES,
        counts=_counts(rows),
        of_many=_of_many,
        claims=[_shown_claim(claim, judged) for claim, judged in content.judged],
        orders=[_order_cells(o) for o in content.orders],
        orders_in_brief=_orders_in_brief(content.orders),
        zeta_ideal=content.orders[0].zeta_ideal,
        errata=[(i, e.place, e.printed, e.correct, e.verified) for i, e in enumerate(ERRATA, 1)],
        parameters=[(p.symbol, p.meaning, p.unit, *p.values, p.source) for p in PARAMETERS],
        cases=tuple(CASES),
        open=OPEN,
    )
    path.write_text(text, encoding="utf-8")
    return path


def _title(figure: Figure) -> str:
    return f"Fig. {figure.id}. {figure.title}" if figure in PAPER else f"Ours. {figure.title}"


def _thinned(chart: Chart) -> Chart:
    return replace(chart, curves=[decimated(curve) for curve in chart.curves])


def _counts(rows: Sequence[Row]) -> dict[str, int]:
    return {verdict: sum(row.verdict == verdict for row in rows) for verdict in _CLASSES}


def _of_many(verdict: str, n: int) -> str:
    """Put a verdict in the plural where it is that of several rows."""
    if n == 1:
        return verdict
    return verdict.replace("does", "do", 1) if verdict == FAILS else verdict.replace("holds", "hold", 1)


def _shown_claim(claim: Claim, rows: Sequence[Row]) -> _ShownClaim:
    counts = _counts(rows)
    return _ShownClaim(
        id=claim.id,
        text=claim.claim,
        place=claim.place,
        why=claim.why,
        bound_from=claim.bound_from,
        verdict=overall(rows),
        counts=", ".join(f"{n} {_of_many(verdict, n)}" for verdict, n in counts.items() if n),
        rows=[_shown_row(claim, row) for row in rows],
    )


def _shown_row(claim: Claim, row: Row) -> _ShownRow:
    return _ShownRow(
        case=row.claim[row.claim.index(" (") + 2 : -1],
        bound=row.bound,
        bound_from="" if row.bound_from == claim.bound_from else row.bound_from,
        measured=row.measured,
        noise=row.noise,
        is_noiseless=row.noise.startswith("no noise"),
        verdict=row.verdict,
        why="" if row.why == claim.why else row.why,
    )


def _order_cells(order: Ordered) -> list[str]:
    late = (
        connection.rpartition(".")[0] for connection in order.late
    )  # the input mostly has the output's name
    return [
        order.name,
        str(order.count),
        f"{order.loop_steps:g}",
        number(order.zeta_none),
        number(order.zeta_compensated),
        ", ".join(late) or "none",
    ]


def _orders_in_brief(orders: Sequence[Ordered]) -> list[list[str]]:
    """Return one class for each number of steps in the loop, the configurations' own first."""
    shown: dict[float, Ordered] = {}
    for order in sorted(orders, key=lambda o: (o.loop_steps, o.name != orders[0].name)):
        shown.setdefault(order.loop_steps, order)
    counts = {steps: sum(o.count for o in orders if o.loop_steps == steps) for steps in shown}
    return [_order_cells(replace(order, count=counts[steps])) for steps, order in shown.items()]
