"""One HTML file with everything: verdict, tables, panels; nothing is fetched."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from fmu_sources.effects.catalogue import effect

from . import tables
from .panels import Panel
from .tables import number

_STYLE = (Path(__file__).parent / "style.html").read_text(encoding="utf-8")
Units = Mapping[str, str]


def page(report: Mapping[str, Any], panels: Sequence[Panel], units: Units) -> str:
    """
    Write the page of a report.

    Args:
        report: What `report.json` holds.
        panels: Pictures that were drawn.
        units: Name of the unit of each variable `fmu.name`.
    """
    body = "\n".join(_sections(report, panels, units))
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<link rel="icon" href="data:,">\n<title>{escape(report["name"])}</title>\n{_STYLE}</head>\n'
        f"<body>\n<main>\n{body}\n</main>\n</body>\n</html>\n"
    )


def _sections(report: Mapping[str, Any], panels: Sequence[Panel], units: Units) -> Iterator[str]:
    yield f"<h1>{escape(report['name'])}: what the model lacks</h1>"
    yield f'<p class="verdict">{escape(report["sentence"])}</p>'
    yield _summary(report, units)
    yield "<h2>Sealed part, before and after</h2>" + tables.errors(report, units)
    yield "<h2>Effects</h2>" + _effects(report["effects"])
    yield "<h2>Parameters</h2>" + tables.parameters(report["parameters"], units)
    yield _families(report["undistinguished"])
    yield "<h2>Runners-up and why they lost</h2>" + tables.runners_up(report["runners_up"])
    yield "<h2>Tests on the residual before an effect was added</h2>" + tables.residuals(report["residual"])
    yield _pictures(panels)
    files = "".join(f"<li><code>{escape(f)}</code></li>" for f in report["files"])
    yield f"<h2>Files</h2><ul>{files}</ul>"


def _summary(report: Mapping[str, Any], units: Units) -> str:
    where = report["subsystem"]
    lines = [f"Verdict: <b>{escape(report['verdict'])}</b>; subsystem: {escape(where or 'none')}."]
    for signal, before in report["before"].items():
        after = report["after"][signal]
        if report["effects"] and None not in (before["rmse"], after["rmse"]) and before != after:
            lines.append(
                f"{escape(signal)} on the sealed part: RMSE {number(before['rmse'])} &rarr; "
                f"<b>{number(after['rmse'])} {escape(units.get(signal, ''))}</b> "
                f"({number(before['nrmse_percent'], 3)} &rarr; {number(after['nrmse_percent'], 3)} %)."
            )
    if report["effects"]:
        share = 100.0 * report["explained_share"]
        lines.append(f"Of the power of the sealed residual {number(share, 3)} % is explained.")
    return "".join(f"<p>{line}</p>" for line in lines)


def _effects(effects: Iterable[Mapping[str, Any]]) -> str:
    items = "".join(
        f"<li><b>{escape(e['effect'])}</b> in <code>{escape(e['fmu'])}.{escape(e['slot'])}</code>: "
        f"{escape(effect(e['effect']).description.lower())}.</li>"
        for e in effects
    )
    return f"<ul>{items}</ul>" if items else "<p>None was added.</p>"


def _families(found: Sequence[Mapping[str, Any]]) -> str:
    if not found:
        return ""
    items = "".join(
        f"<li>{escape(' or '.join(f['family']))}. <b>{escape(f['experiment'])}</b></li>" for f in found
    )
    return f"<h2>Cannot be told apart with this recording</h2><ul>{items}</ul>"


def _pictures(panels: Sequence[Panel]) -> str:
    text = "<h2>Panels</h2>"
    for i, panel in enumerate(panels):
        if i == 0 or panels[i - 1].part != panel.part:
            text += f"<h3>{escape(panel.part)}</h3>"
        data = base64.b64encode(panel.file.read_bytes()).decode()
        text += (
            f'<figure><img alt="{escape(panel.file.stem)}" src="data:image/png;base64,{data}">'
            f"<figcaption>{escape(panel.text)}</figcaption></figure>"
        )
    return text
