"""The page: one HTML file with style, script and data inside."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from master.reproduce.claims.claim import CONDITION, FAILS, HOLDS, Claim, Row, overall
from master.reproduce.facts.errata import ERRATA
from master.reproduce.facts.orders import Ordered
from master.reproduce.facts.parameters import OPEN, PARAMETERS
from master.reproduce.figures.plot import Panel, as_data
from master.reproduce.figures.registry import FIGURES, PAPER

_CLASS = {HOLDS: "holds", CONDITION: "condition", FAILS: "fails"}
_HERE = Path(__file__).parent


@dataclass(frozen=True)
class Content:
    """All that the page shows: panels by figure, rows by claim, orders."""

    panels: Mapping[str, Sequence[Panel]]
    judged: Sequence[tuple[Claim, Sequence[Row]]]
    orders: Sequence[Ordered]


def write_page(content: Content, path: Path) -> Path:
    """Write the page."""
    data = {name: [as_data(p) for p in panels] for name, panels in content.panels.items()}
    text = json.dumps(data, allow_nan=False, separators=(",", ":")).replace("</", "<\\/")
    body = "\n".join(
        (_head(content), _figures(), _claims(content), _orders(content), _errata(), _parameters())
    )
    page = (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<link rel="icon" href="data:,">\n<title>The paper, reproduced and judged</title>\n'
        f"{_part('style.html')}</head>\n<body>\n<main>\n{body}\n</main>\n"
        f'<script type="application/json" id="data">{text}</script>\n'
        f"{_part('plotter.html')}</body>\n</html>\n"
    )
    path.write_text(page, encoding="utf-8")
    return path


def number(value: float | None) -> str:
    """Give a measured value for people."""
    return "-" if value is None else f"{value:.4g}"


def _part(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")


def _table(heads: Sequence[str], rows: Iterable[str]) -> str:
    head = "".join(f"<th>{escape(h)}</th>" for h in heads)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"


def _row(*cells: str) -> str:
    return "<tr>" + "".join(f"<td{_number_class(c)}>{escape(c)}</td>" for c in cells) + "</tr>"


def _number_class(cell: str) -> str:
    return ' class="number"' if cell.lstrip("-").replace(".", "", 1).replace(" ", "").isdigit() else ""


def _head(content: Content) -> str:
    rows = [row for _, judged in content.judged for row in judged]
    numbers = {v: sum(r.verdict == v for r in rows) for v in _CLASS}
    counts = "".join(
        f'<span class="{_CLASS[v]}"><b>{n}</b> {_of_many(v, n)}</span>' for v, n in numbers.items()
    )
    links = "".join(
        f'<a href="#{place}">{text}</a>'
        for place, text in (
            ("figures", "Figures"),
            ("claims", "Claims"),
            ("orders", "Orders of stepping"),
            ("errata", "Errata"),
            ("parameters", "Parameters"),
        )
    )
    return (
        "<h1>The paper, reproduced and judged</h1>"
        '<p class="lead">A Force and Displacement Compensation Method Toward Divergence and Accuracy of '
        "Hardware-In-the-Loop Simulation System for Manipulator Docking. Every curve and "
        "number here comes from "
        "runs of the FMUs: with the hexapod, the paper's plant, unless the linear plant is named.</p>"
        f'<p class="counts">{counts}</p><nav>{links}</nav>'
    )


def _figures() -> str:
    hint = (
        '<p class="soft">Drag over a plot to zoom, double-click for all, click a label to hide a curve.</p>'
    )
    found = ['<h2 id="figures">Figures</h2>', hint]
    for figure in FIGURES:
        name = f"Fig. {figure.id}. " if figure in PAPER else "Ours. "
        found.append(
            f'<figure id="figure-{figure.id}" data-figure="{figure.id}">'
            f"<h3>{escape(name + figure.title)}</h3>"
            f'<div class="panels"></div><figcaption><p><b>Paper:</b> {escape(figure.paper)}.</p>'
            f"<p><b>Here:</b> {escape(figure.ours)}.</p></figcaption></figure>"
        )
    return "\n".join(found)


def _claims(content: Content) -> str:
    rows = []
    for claim, judged in content.judged:
        bounds = f" Bounds: {escape(claim.bound_from)}." if claim.bound_from else ""
        rows.append(
            f'<tr class="claim" id="claim-{claim.id}"><td colspan="5"><b>{escape(claim.claim)}.</b> '
            f'<span class="soft">{escape(claim.place)}; {escape(claim.id)}</span><br>'
            f"{escape(_sentence(claim.why))}{bounds}</td></tr>"
        )
        rows += [_claim_row(row, claim) for row in judged]
    heads = ("case", "bound", "measured", "verdict", "why")
    return (
        '<h2 id="claims">Claims</h2><p>No bound follows from the value that is measured: a bound is what '
        "its claim or the line below it says (physics.md: the project's reference, conventions, criteria "
        "and numbers of another simulation). Each value comes from runs of the FMUs with ten noise seeds, "
        "and the worst counts; one with a circle (\u25e6) has no noise in it: a pole of the linearised FMUs, "
        "or the real docking alone. Where bound or reason are not given they are those of the claim.</p>"
        + _summary(content)
        + "<h3>Every row</h3>"
        + _table(heads, rows).replace("<table>", '<table class="rows">', 1)
    )


def _sentence(text: str) -> str:
    """Give a sentence its capital, unless it begins with a symbol."""
    first = text.split(" ", 1)[0]
    return f"{text[:1].upper() if first.isalpha() else text[:1]}{text[1:]}."


def _of_many(verdict: str, n: int) -> str:
    """Give a verdict as what so many rows do."""
    if n == 1:
        return verdict
    return verdict.replace("does", "do", 1) if verdict == FAILS else verdict.replace("holds", "hold", 1)


def _summary(content: Content) -> str:
    rows = []
    for claim, judged in content.judged:
        verdict = overall(judged)
        counts = {v: sum(r.verdict == v for r in judged) for v in _CLASS}
        shown = ", ".join(f"{n} {_of_many(v, n)}" for v, n in counts.items() if n)
        rows.append(
            f'<tr><td><a href="#claim-{claim.id}">{escape(claim.claim)}</a></td>'
            f"<td>{escape(claim.place)}</td>"
            f'<td class="verdict {_CLASS[verdict]}">{verdict}</td><td>{shown}</td></tr>'
        )
    return _table(("claim", "place", "as a whole", "rows"), rows)


def _claim_row(row: Row, claim: Claim) -> str:
    case = row.claim[row.claim.index(" (") + 2 : -1]
    own = [
        text if text != of else "" for text, of in ((row.bound_from, claim.bound_from), (row.why, claim.why))
    ]
    source = f'<br><span class="soft">{escape(own[0])}</span>' if own[0] else ""
    mark = " \u25e6" if row.noise.startswith("no noise") else ""
    return (
        f"<tr><td>{escape(case)}</td><td>{escape(row.bound)}{source}</td>"
        f'<td class="number" title="{escape(row.noise)}">{number(row.measured)}{mark}</td>'
        f'<td class="verdict {_CLASS[row.verdict]}">{row.verdict}</td><td>{escape(own[1])}</td></tr>'
    )


def _orders(content: Content) -> str:
    def cells(o: Ordered) -> tuple[str, ...]:
        none, compensated = (number(z) for z in o.zeta)
        return (
            o.name,
            str(o.count),
            f"{o.loop_steps:g}",
            none,
            compensated,
            ", ".join(map(_brief, o.late)) or "none",
        )

    shown: dict[float, Ordered] = {}
    for o in sorted(content.orders, key=lambda o: (o.loop_steps, o.name != content.orders[0].name)):
        shown.setdefault(o.loop_steps, o)
    counts = {s: sum(o.count for o in content.orders if o.loop_steps == s) for s in shown}
    heads = (
        "order",
        "orders like it",
        "steps in the force loop",
        "zeta, none",
        "zeta, CFDC",
        "one step late",
    )
    brief = [_row(o.name, str(counts[s]), *cells(o)[2:]) for s, o in shown.items()]
    return (
        '<h2 id="orders">Orders of stepping</h2><p>The paper does not say in which order '
        "its parts are computed in "
        f"a period. Here is case S1 with the linear plant and exact parameters (real docking: zeta "
        f"{number(content.orders[0].zeta_ideal)}): only the steps in the force loop count, "
        "each costs w T/2 of "
        "damping. A real rig has two of them at least: a command acts over one period, and what it "
        "does is read at the next. With these two the method gives the ideal damping. One more takes "
        "60 % of it, two more make the compensated loop diverge. Iteration has none; no rig can be "
        "stepped so, and it damps too much.</p>"
        + _table(heads, brief)
        + "<details><summary>All classes of orders</summary>"
        + _table(heads, [_row(*cells(o)) for o in content.orders])
        + "</details>"
    )


def _brief(connection: str) -> str:
    """Leave the name of the input out: it is that of the output nearly everywhere."""
    return connection.rpartition(".")[0]


def _errata() -> str:
    rows = [_row(str(i), e.place, e.printed, e.correct, e.verified) for i, e in enumerate(ERRATA, 1)]
    return '<h2 id="errata">Errata of the paper</h2>' + _table(
        ("#", "place", "printed", "correct", "verified"), rows
    )


def _parameters() -> str:
    rows = [_row(p.symbol, p.meaning, p.unit, *p.values, p.source) for p in PARAMETERS]
    points = "".join(f"<li>{escape(p)}</li>" for p in OPEN)
    return (
        '<h2 id="parameters">Parameters</h2>'
        + _table(("symbol", "meaning", "unit", "S1", "S2", "E1", "E2", "where it comes from"), rows)
        + f"<h3>What is not determined</h3><ul>{points}</ul>"
    )
