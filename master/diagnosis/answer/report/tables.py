"""Tables of the page: errors, parameters, runners-up, tests."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from master.pages.render import number

MODELS = ("nominal", "before", "after")
LEVEL = 0.01


@dataclass(frozen=True)
class Table:
    """Cells as text, the places of the columns with numbers, a note below, and what is said without rows."""

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    numbers: Sequence[int] = ()
    note: str = ""
    none: str = ""


def errors(report: Mapping[str, Any], units: Mapping[str, str]) -> Table:
    """RMSE with its interval, NRMSE, maximum and energy of each signal."""
    rows = []
    for signal in report["before"]:
        for which in MODELS:
            e = report[which][signal]
            interval = e["rmse_interval"]
            shown = "-" if interval is None else f"{number(interval[0])} to {number(interval[1])}"
            name = f"{signal} [{units.get(signal, '1')}]" if which == "nominal" else ""
            others = (number(e[k]) for k in ("nrmse_percent", "max", "energy"))
            rows.append([name, which, number(e["rmse"]), shown, *others])
    head = ["signal", "model", "RMSE", "95 % interval", "NRMSE [%]", "maximum", "energy [1]"]
    note = (
        "nominal: parameters as in the system; before: refitted; after: with the effect, as the FMUs that "
        "were written give it. Interval: bootstrap in blocks longer than the residual's correlation. NRMSE: "
        "relative to the rms of what was measured. Energy: simulated over measured."
    )
    return Table(head, rows, (2, 3, 4, 5, 6), note)


def parameters(found: Mapping[str, Mapping[str, Any]], units: Mapping[str, str]) -> Table:
    """Each parameter with its unit, before and after, with one standard deviation."""
    rows = [
        [
            name,
            units.get(name, "1"),
            number(p["nominal"]),
            _uncertain(p["refitted"], p["deviation_refitted"]),
            _with_effect(p),
        ]
        for name, p in found.items()
    ]
    head = ["parameter", "unit", "nominal", "refitted, before", "with effect, after"]
    note = (
        "One standard deviation that holds where the residual is coloured. What has no number could be "
        "nearly anything; the corrected model has the best of it."
    )
    return Table(head, rows, (2, 3, 4), note, none="None was fitted.")


def recordings(found: Mapping[str, Mapping[str, Any]]) -> Table:
    """Rows of each recording, their period, and what was done to how many of them."""
    rows = [[name, str(r["rows"]), number(r["period"]), "; ".join(r["notes"])] for name, r in found.items()]
    return Table(["recording", "rows", "period [s]", "what was done to its rows"], rows, (1, 2), "")


def runners_up(found: Iterable[Mapping[str, Any]]) -> Table:
    """Effects that were fitted and not taken."""
    rows = [
        [
            str(r["round"]),
            r["effect"],
            number(r["gain"], 3),
            ", ".join(f"{signal} {number(left, 4)}" for signal, left in r.get("sealed_rmse", {}).items()),
            r["why"],
        ]
        for r in found
    ]
    head = ["round", "effect", "gain [1]", "left on the sealed rows, RMSE", "why it lost"]
    return Table(head, rows, (2,), none="No other effect came near.")


def channels(found: Mapping[str, Mapping[str, Any]], units: Mapping[str, str]) -> Table:
    """What each model leaves of each channel, over its noise floor, and what still predicts it."""
    rows = []
    for signal, c in found.items():
        for i, stage in enumerate(c["stages"]):
            low, high = stage["interval"]
            best = stage["predictors"][0]["what"] if stage["predictors"] else ""
            floor = f"{number(c['noise_floor'])} ({c['evidence']})"
            rows.append(
                [
                    f"{signal} [{units.get(signal, '1')}]" if i == 0 else "",
                    floor if i == 0 else "",
                    stage["model"],
                    number(stage["rms"]),
                    number(stage["over_floor"], 3),
                    f"{number(100.0 * stage['predictable_share'], 3)} ({_percent(low)} to {_percent(high)})",
                    best,
                ]
            )
    head = ["signal", "noise floor", "model", "left", "over the floor", "predictable [%]", "best by"]
    note = (
        "On the open rows. Noise floor: standard deviation that the channel cannot fall below, and the "
        "evidence for it; what the noise of the inputs adds counts in the ratio. Predictable: share of the "
        "power left that a regression without physics predicts on blocks it has not seen (95 % interval)."
    )
    return Table(head, rows, (3, 4), note, none="All parts replay to rounding.")


def _percent(share: float) -> str:
    return number(100.0 * share, 2)


def residuals(found: Mapping[str, Mapping[str, Any]]) -> Table:
    """What the tests say of each part."""
    head = [
        "part",
        "strongest cross-correlation",
        "drifting parameters",
        "whiteness, p",
    ]
    note = (
        "Cross-correlations are prewhitened and corrected for all signals and lags. Whiteness is reported "
        "and decides nothing."
    )
    return Table(head, [_tests(part, r) for part, r in found.items()], note=note)


def _tests(part: str, r: Mapping[str, Any]) -> list[str]:
    if r["exact"]:
        return [part, "replayed to rounding", "", ""]
    best = next((c for c in r["correlations"] if c["found"]), None)
    drifting = [d["parameter"] for d in r["drift"] if d["p_equal"] < LEVEL]
    return [
        part,
        "none" if best is None else f"{best['basis']} at lag {best['lag']}, p = {number(best['p'], 2)}",
        ", ".join(drifting) or "none",
        number(r["whiteness_p"], 2),
    ]


def _with_effect(p: Mapping[str, Any]) -> str:
    if p["no_number"]:
        return f"no number: {p['no_number']}"
    return _uncertain(p["with_effect"], p["deviation"]) + (" (at its bound)" if p["at_bound"] else "")


def _uncertain(value: Any, deviation: Any) -> str:
    return "-" if value is None else f"{number(value, 5)} ± {number(deviation, 2)}"
