"""The comparison as text, as `docs/performance.md`, and as a plot."""

from __future__ import annotations

import os
import platform
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure
from peers import FLOOR, OURS

DOCS = Path(__file__).parents[1] / "docs"
_BEGIN, _END = "<!-- measured -->", "<!-- end of measured -->"


def text(rows: list[dict]) -> str:
    """Markdown table, a line a master and system."""
    head = ["| system | master | us/step | least | ratio to floor | version |", "|---|---|---|---|---|---|"]
    return "\n".join([*head, *map(_line, rows)])


def _line(row: dict) -> str:
    if row["us_per_step"] is None:
        return f"| {row['system']} | {row['master']} | not run: {row['problem']} | | | |"
    numbers = f"{row['us_per_step']:.3g} | {row['least']:.3g} | {row['ratio_to_floor']:.2f}"
    return f"| {row['system']} | {row['master']} | {numbers} | {row['version']} |"


def write(rows: list[dict], growth: dict) -> None:
    """Put the measured part into the document and draw the plot."""
    DOCS.mkdir(exist_ok=True)
    document = DOCS / "performance.md"
    before, _, rest = document.read_text(encoding="utf-8").partition(_BEGIN)
    after = rest.partition(_END)[2]
    document.write_text(
        f"{before}{_BEGIN}\n\n{_measured(rows, growth)}\n\n{_END}{after}", encoding="utf-8", newline="\n"
    )
    _plot(rows, growth)


def _measured(rows: list[dict], growth: dict) -> str:
    machine = f"{platform.machine()}, {os.cpu_count()} processors, Python {platform.python_version()}"
    fmus = [f"| {n} | {us:.3g} | {us / n:.3f} |" for n, us in growth["us_per_step_by_fmus"].items()]
    streamed = [
        f"| {seconds:g} | {found['us_per_step']:.3g} | {found['memory_mb']:.0f} |"
        for seconds, found in growth["streamed_by_seconds"].items()
    ]
    parts = [
        [f"Measured on {machine}; medians of {rows[0]['repetitions']} repetitions in turns.", "", text(rows)],
        ["| FMUs in the ring | us/step | us/step and FMU |", "|---|---|---|", *fmus],
        _two("connections of 5 FMUs", growth["us_per_step_by_connections"]),
        _two("recorded signals of 5 FMUs", growth["us_per_step_by_signals"]),
        [
            "| simulated seconds, results written | us/step, with writing | largest resident memory, MB |",
            "|---|---|---|",
            *streamed,
        ],
    ]
    return "\n\n".join("\n".join(part) for part in parts)


def _two(what: str, found: dict[int, float]) -> list[str]:
    return [f"| {what} | us/step |", "|---|---|", *(f"| {n} | {us:.3g} |" for n, us in found.items())]


def _plot(rows: list[dict], growth: dict) -> None:
    mpl.use("Agg")
    figure = Figure(figsize=(11.0, 3.6), layout="constrained")
    bars, lines = figure.subplots(1, 2, width_ratios=(1.4, 1.0))
    shown = [r for r in rows if r["system"] == rows[0]["system"] and r["us_per_step"] is not None][::-1]
    colours = [{OURS: "tab:blue", FLOOR: "0.6"}.get(r["master"], "tab:orange") for r in shown]
    drawn = bars.barh([r["master"] for r in shown], [r["us_per_step"] for r in shown], color=colours)
    bars.bar_label(drawn, fmt="%.3g", padding=3)
    bars.set(xscale="log", xlabel="time per step [us]", title=f"{rows[0]['system']}: five FMUs")
    bars.margins(x=0.2)
    for master in dict.fromkeys(r["master"] for r in rows):
        points = [
            (int(r["system"].partition("_")[2]), r["us_per_step"])
            for r in rows
            if r["master"] == master and r["system"].startswith("ring") and r["us_per_step"] is not None
        ]
        if points:
            lines.plot(*zip(*points, strict=True), "o-", label=master)
    lines.set(xscale="log", yscale="log", xlabel="FMUs in the ring", ylabel="time per step [us]")
    lines.legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    figure.savefig(DOCS / "performance.png", dpi=120, metadata={"Software": None})
