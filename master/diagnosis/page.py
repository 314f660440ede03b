"""One HTML file with everything: verdict, tables, panels; nothing is fetched."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #222; }
body { margin: 2rem auto; max-width: 62rem; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: .2rem; } h2 { font-size: 1.1rem; margin-top: 2rem; }
.verdict { font-size: 1.2rem; padding: .8rem 1rem; background: #eef3fa; border-left: 4px solid #4c72b0; }
table { border-collapse: collapse; margin: .5rem 0; } td, th { padding: .2rem .7rem; text-align: right; }
th { border-bottom: 1px solid #999; } td:first-child, th:first-child, td.text { text-align: left; }
tr:nth-child(even) { background: #f6f6f6; } img { max-width: 100%; } code { background: #f3f3f3; }
"""


def page(report: Mapping[str, Any], panels: Sequence[Path]) -> str:
    """Write the page of a report."""
    parts = [
        f"<h1>{escape(report['name'])}</h1>",
        f"<p class=verdict>{escape(report['sentence'])}</p>",
        f"<p>Verdict: <b>{escape(report['verdict'])}</b>. "
        f"Subsystem: {escape(str(report['subsystem'] or 'none'))}. "
        f"Explained share of the sealed residual: {_number(report['explained_share'])}.</p>",
        "<h2>Sealed part, before and after</h2>",
        _errors(report),
        _effects(report["effects"]),
        "<h2>Parameters</h2>",
        _parameters(report["parameters"]),
        _families(report["undistinguished"]),
        "<h2>Runners-up and why they lost</h2>",
        _table(
            ["round", "effect", "gain", "why"],
            [[str(r["round"]), r["effect"], _number(r["gain"]), r["why"]] for r in report["runners_up"]],
        ),
        "<h2>Tests on the residual</h2>",
        _residuals(report["residual"]),
        "<h2>Panels</h2>",
        *(_image(path) for path in panels),
        "<h2>Files</h2>",
        "<ul>" + "".join(f"<li><code>{escape(f)}</code></li>" for f in report["files"]) + "</ul>",
    ]
    head = f"<meta charset=utf-8><title>{escape(report['name'])}</title><style>{STYLE}</style>"
    return f"<!doctype html><html lang=en><head>{head}</head><body>{''.join(parts)}</body></html>\n"


def _errors(report: Mapping[str, Any]) -> str:
    rows = []
    for signal in report["before"]:
        for which in ("nominal", "before", "after"):
            e = report[which][signal]
            interval = e["rmse_interval"]
            shown = "-" if interval is None else f"{_number(interval[0])} to {_number(interval[1])}"
            numbers = [_number(e[k]) for k in ("rmse", "nrmse_percent", "max", "energy")]
            rows.append([signal, which, numbers[0], shown, *numbers[1:]])
    head = ["signal", "model", "RMSE [SI]", "95 % interval", "NRMSE [%]", "maximum [SI]", "energy ratio"]
    note = "<p>nominal: as in the system; before: parameters refitted; after: with what was added.</p>"
    return _table(head, rows) + note


def _effects(effects: Iterable[Mapping[str, Any]]) -> str:
    rows = []
    for e in effects:
        shown = {k: v for k, v in e["parameters"].items() if not k.startswith("c_")}
        text = ", ".join(f"{k} = {_number(v)}" for k, v in shown.items())
        rows.append([f"{e['fmu']}.{e['slot']}", e["effect"], text])
    return "<h2>Effects</h2>" + (
        _table(["slot", "effect", "parameters [SI]"], rows) if rows else "<p>None.</p>"
    )


def _parameters(parameters: Mapping[str, Mapping[str, float]]) -> str:
    rows = [
        [
            name,
            _number(p["nominal"]),
            f"{_number(p['refitted'])} +- {_number(p['deviation_refitted'], 2)}",
            f"{_number(p['with_effect'])} +- {_number(p['deviation'], 2)}",
        ]
        for name, p in parameters.items()
    ]
    return _table(["parameter [SI]", "nominal", "refitted without effect", "with effect"], rows)


def _families(found: Sequence[Mapping[str, Any]]) -> str:
    if not found:
        return ""
    items = "".join(f"<li>{escape(' or '.join(f['family']))}. {escape(f['experiment'])}</li>" for f in found)
    return f"<h2>Cannot be told apart with this recording</h2><ul>{items}</ul>"


def _residuals(residual: Mapping[str, Mapping[str, Any]]) -> str:
    rows = []
    for part, r in residual.items():
        if r["exact"]:
            rows.append([part, "replayed to rounding", "", "", ""])
            continue
        best = next((c for c in r["correlations"] if c["found"]), None)
        drifting = [d["parameter"] for d in r["drift"] if d["p_equal"] < 0.01]
        c = r["ceiling"]
        rows.append(
            [
                part,
                "none" if best is None else f"{best['basis']} at lag {best['lag']}, p = {_number(best['p'])}",
                "-" if c is None else f"{_number(c['share'])} +- {_number(c.get('error', 0.0), 2)}",
                ", ".join(drifting) or "none",
                _number(r["whiteness_p"]),
            ]
        )
    head = [
        "part",
        "strongest cross-correlation",
        "ceiling, share",
        "drifting parameters",
        "whiteness p (report only)",
    ]
    return _table(head, rows)


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    body = "".join("<tr>" + "".join(f"<td>{escape(c)}</td>" for c in row) + "</tr>" for row in rows)
    return f"<table><tr>{''.join(f'<th>{escape(h)}</th>' for h in head)}</tr>{body}</table>"


def _image(path: Path) -> str:
    data = base64.b64encode(path.read_bytes()).decode()
    return f'<h3>{escape(path.stem)}</h3><img alt="{escape(path.stem)}" src="data:image/png;base64,{data}">'


def _number(value: Any, digits: int = 4) -> str:
    return "-" if value is None else f"{float(value):.{digits}g}"
