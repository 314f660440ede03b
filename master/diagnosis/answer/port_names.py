"""An answer in the names of the case: ports of foreign FMUs in the place of the followers that carry them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from master.diagnosis.case.cut import CutSystem
from master.pages.chart import Chart


def with_port_names(report: Mapping[str, Any], system: CutSystem) -> dict[str, Any]:
    """Return a report that names ports where it named followers, in its keys and texts; files keep theirs."""
    if not system.carriers:
        return dict(report)
    renamed = {key: value if key == "files" else _renamed(value, system) for key, value in report.items()}
    renamed["effects"] = [_at_port(own, system) for own in renamed["effects"]]
    carrier = system.carriers.get(renamed["subsystem"])
    if carrier is not None:
        renamed["subsystem"] = carrier.fmu
    return renamed


def chart_with_port_names(chart: Chart, system: CutSystem) -> Chart:
    """Return a chart whose title, labels and curves name ports."""
    if not system.carriers:
        return chart
    return replace(
        chart,
        title=system.spoken(chart.title),
        x_label=system.spoken(chart.x_label),
        y_label=system.spoken(chart.y_label),
        curves=[replace(c, label=system.spoken(c.label), like=system.spoken(c.like)) for c in chart.curves],
    )


def _renamed(value: Any, system: CutSystem) -> Any:
    if isinstance(value, str):
        return system.spoken(value)
    if isinstance(value, Mapping):
        return {system.spoken(key): _renamed(own, system) for key, own in value.items()}
    if isinstance(value, list):
        return [_renamed(own, system) for own in value]
    return value


def _at_port(effect: Mapping[str, Any], system: CutSystem) -> dict[str, Any]:
    carrier = system.carriers.get(effect["fmu"])
    at = {} if carrier is None else {"fmu": carrier.fmu, "slot": carrier.variable}
    return {**effect, **at}
