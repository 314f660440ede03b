"""
Confusion matrix and rates of trials, in Markdown: python -m tests.rig.trials_table OUT.jsonl ...

An effect that the rig has and the library calls otherwise stands in NAMES; LAG_LIKE are truths that most
recordings cannot tell from others of their kind, and that should come out as a family. What leaves less than
half of the noise, after the refit of the model without it, is counted apart.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path

import numpy as np

from tests.rig import SUBSYSTEM, UNLISTED

NAMES = {
    **{"cubic": "cubic_stiffness", "backlash": "clearance", "mount": "mount_resonance", "gain": "gain_error"},
    **{
        "lag": "extra_lag",
        "slow_filter": "extra_lag",
        "delay": "extra_delay",
        "simulator_delay": "extra_delay",
    },
    **{"inertia": "end_effector_inertia", "spacecraft_offset": "offset", "rate_limit": "rate_saturation"},
    **{"force_limit": "force_saturation", "speed_limit": "force_saturation", "simulator_gain": "gain_error"},
    **{"command_quantisation": "quantisation", "correction_saturation": "force_saturation"},
}
LAG_LIKE = {"mount", "lag", "slow_filter", "delay", "inertia", "simulator_delay"}
SMALLEST_SIZE = 0.5
SILENT = ("nothing missing", "parameters only")


def read(paths: list[Path]) -> list[dict]:
    """Rows of all files."""
    return [json.loads(line) for path in paths for line in path.read_text().splitlines()]


def kinds_of(truth: str) -> list[str]:
    """Effects that are on."""
    return [] if truth.startswith("none") else truth.removesuffix(":small").split("+")


def kinds(row: dict) -> list[str]:
    """Effects that were on."""
    return kinds_of(row["truth"])


def names(row: dict) -> list[str]:
    """Names that were given."""
    return [e.rpartition(":")[2] for e in row.get("effects", []) if "learned_" not in e]


def members(row: dict) -> set[str]:
    """Names in families."""
    return {n.rpartition(": ")[2] for f in row.get("families", []) for m in f for n in m.split(" and ")}


def outcome(row: dict) -> str:
    """A few words for the table."""
    if row["verdict"] in (*SILENT, "undeclared", "error"):
        return row["verdict"]
    if row["verdict"] == "one of a class":
        alone = [n for n in names(row) if n not in members(row)]
        return " + ".join([*alone, "family " + " or ".join(sorted(members(row)))])
    return " + ".join(names(row)) + (" + remainder" if row["verdict"].startswith("partly") else "")


def table(rows: list[dict]) -> str:
    """Truth, seeds, outcomes with counts, subsystem, median share of the ideal gain."""
    lines = [
        "| truth | trials (seeds) | outcome: count | subsystem right | share of the ideal gain |",
        "|---|---|---|---|---|",
    ]
    for truth in dict.fromkeys(r["truth"] for r in rows):
        own = [r for r in rows if r["truth"] == truth]
        counts = Counter(map(outcome, own)).most_common()
        text = "; ".join(f"{k}: {n}" for k, n in counts)
        seeds = sorted(r["seed"] for r in own)
        shares = [r["share_of_ideal"] for r in own if r.get("effects")]
        share = f"{np.median(shares):.2f}" if shares else "-"
        place = "-" if truth.startswith("none") else f"{sum(map(_is_placed, own))}/{len(own)}"
        lines.append(f"| {truth} | {len(own)} ({seeds[0]}..{seeds[-1]}) | {text} | {place} | {share} |")
    return "\n".join(lines)


def rates(rows: list[dict]) -> str:
    """Counts against the bounds."""
    none = [r for r in rows if not kinds(r)]
    one = [r for r in rows if len(kinds(r)) == 1]
    unlisted = [r for r in one if kinds(r)[0] in UNLISTED]
    sized = [r for r in one if r not in unlisted and r.get("size_over_noise", np.inf) >= SMALLEST_SIZE]
    small = [r for r in one if r not in unlisted and r not in sized]
    lag_like = [r for r in sized if kinds(r)[0] in LAG_LIKE]
    listed = [r for r in sized if r not in lag_like]
    pairs = [r for r in rows if len(kinds(r)) == 2]
    checks = [
        ("no effect: claimed", "<= 2 %", none, lambda r: bool(r.get("effects"))),
        ("listed: found", ">= 95 %", listed, _is_found),
        ("listed: right name", ">= 95 %", listed, lambda r: names(r) == _wanted(r) and not r["families"]),
        ("listed: >= 80 % of the ideal gain", ">= 95 %", listed, lambda r: r.get("share_of_ideal", 0) >= 0.8),
        (
            "lag-like: a family with the truth in it",
            ">= 95 %",
            lag_like,
            lambda r: set(_wanted(r)) <= members(r),
        ),
        ("unlisted: detected", ">= 90 %", unlisted, _is_found),
        ("unlisted: wrongly named", "<= 5 %", unlisted, lambda r: bool(names(r))),
        (
            "unlisted: after < before, sealed",
            "all",
            unlisted,
            lambda r: r.get("after", 1) < r.get("before", 0),
        ),
        ("below half of the noise: found", "none", small, _is_found),
        ("pairs: both, or one and a remainder", ">= 80 %", pairs, _is_pair),
        ("subsystem", ">= 95 %", [*sized, *unlisted], _is_placed),
    ]
    lines = ["| check | bound | count |", "|---|---|---|"]
    lines += [
        f"| {what} | {bound} | {sum(map(f, own))}/{len(own)} |" for what, bound, own, f in checks if own
    ]
    return "\n".join(lines)


def _wanted(row: dict) -> list[str]:
    return [NAMES.get(k, k) for k in kinds(row)]


def _is_found(row: dict) -> bool:
    return row["verdict"] not in (*SILENT, "error")


def _is_placed(row: dict) -> bool:
    return (row.get("subsystem") or "") in {SUBSYSTEM[k] for k in kinds(row)}


def _is_pair(row: dict) -> bool:
    given = {*names(row), *members(row), *(o.rpartition(": ")[2] for o in row.get("others", []))}
    found = sum(n in given for n in _wanted(row))
    return found == 2 or (found == 1 and row["verdict"].startswith("partly"))


if __name__ == "__main__":
    found = read([Path(a) for a in sys.argv[1:]])
    sys.stdout.write(f"{rates(found)}\n\n{table(found)}\n")
