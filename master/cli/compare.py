"""`dockloop compare`: runs against the first of them, signal by signal."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from master.errors import EXIT_DIFFERENT, ConfigError, Problem
from master.runs.differences import Comparison, Demands, SignalDifference, Tolerance, compare_runs
from master.runs.run_data import read_run

from .common import JSON, answers_errors, print_json, say

_WIDTHS = (12, 11, 12, 12, 10)
_HEADS = ("max abs", "at [s]", "rms", "first [s]", "rows")


@click.command()
@click.argument("runs", nargs=-1, required=True, metavar="RUN RUN ...", type=click.Path(path_type=Path))
@click.option(
    "--tolerance",
    "tolerances",
    multiple=True,
    metavar="[SIGNAL=]VALUE[%]",
    help="Allow differences up to a value in the signal's unit, or up to a share (%) of its largest "
    "magnitude; for one signal, or for all that are not named. Without it, bits must be equal.",
)
@click.option(
    "--signal", "signals", multiple=True, metavar="SIGNAL", help="Compare this one; may be repeated."
)
@click.option(
    "--common", is_flag=True, help="Compare the signals and times that both have; the rest is said."
)
@click.option(
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Draw the runs over each other: a page (.html) or a picture (.png).",
)
@JSON
@answers_errors
def compare(
    runs: tuple[Path, ...],
    tolerances: tuple[str, ...],
    signals: tuple[str, ...],
    common: bool,
    output: Path | None,
    as_json: bool,
) -> None:
    """
    Compare runs with the first of them: results folders, or CSV and Parquet files of any tool.

    Exit status 0 within the tolerance (equal bits without one), 1 beyond it, 2 if the input is wrong.
    """
    demands = _demands(runs, tolerances, signals, common, output)
    reference, *others = [read_run(path) for path in runs]
    found = [compare_runs(reference, other, demands) for other in others]
    if output is not None:
        from master.runs.overlay import draw

        draw(found, output)
    if as_json:
        print_json({"within": all(c.is_within for c in found), "comparisons": [c.as_dict() for c in found]})
    else:
        for comparison in found:
            for line in _lines(comparison):
                say(line)
        if output is not None:
            say(f"drawn: {output}")
    sys.exit(0 if all(c.is_within for c in found) else EXIT_DIFFERENT)


def _demands(
    runs: tuple[Path, ...],
    tolerances: tuple[str, ...],
    signals: tuple[str, ...],
    common: bool,
    output: Path | None,
) -> Demands:
    problems = []
    if len(runs) < 2:
        problems.append(Problem("runs", where="compare", got="1", expected="2 or more"))
    if output is not None and output.suffix.lower() not in (".html", ".png"):
        problems.append(Problem("ending", where="--output", got=repr(output.name), expected=".html or .png"))
    general: Tolerance | None = None
    by_signal: dict[str, Tolerance] = {}
    for text in tolerances:
        signal, _, value = text.rpartition("=")
        try:
            tolerance = Tolerance.of(value)
        except ValueError:
            expected = "a number of at least 0 or a percentage, after `SIGNAL=` or alone"
            problems.append(Problem("tolerance", where="--tolerance", got=repr(text), expected=expected))
            continue
        if signal in by_signal or (not signal and general is not None):
            what = f"is given twice{f' for {signal}' if signal else ''}"
            problems.append(Problem(what, where="--tolerance", got=repr(text), expected="one value"))
        elif signal:
            by_signal[signal] = tolerance
        else:
            general = tolerance
    if problems:
        raise ConfigError(problems)
    return Demands(general, by_signal, signals, common)


def _lines(comparison: Comparison) -> list[str]:
    n = len(comparison.differences)
    tolerance = comparison.demands.tolerance
    asked = "equal bits" if tolerance is None else f"differences up to {tolerance}"
    verdict = "within" if comparison.is_within else "NOT within"
    lines = [
        f"{comparison.other.label} against {comparison.reference.label}: {verdict} what is asked ({asked})"
    ]
    lines.append(f"  {comparison.rows} common rows, {n} common signals")
    apart = [d for d in comparison.differences if d.unequal or not d.is_within]
    if apart:
        wide = max(len(_named(d)) for d in apart) + 2
        heads = "".join(f"{head:>{width}}" for head, width in zip(_HEADS, _WIDTHS, strict=True))
        lines.append(f"  {'signal':<{wide}}{heads}")
        lines += [f"  {_named(d):<{wide}}{_row(d)}" for d in apart]
    if n > len(apart):
        lines.append(f"  equal bits in {n - len(apart)} signals")
    lines += [f"  note: {line}" for line in comparison.renamed]
    if comparison.demands.only_common:
        lines += [f"  note: {line}" for line in comparison.not_shared]
    return lines + [f"  {line}" for line in comparison.faults]


def _named(d: SignalDifference) -> str:
    return f"{d.name} [{d.unit}]" if d.unit else d.name


def _row(d: SignalDifference) -> str:
    sizes = [_number(d.max_abs, ".4g"), _number(d.max_at, ".6g"), _number(d.rms, ".4g")]
    cells = [*sizes, _number(d.first_beyond, ".6g"), str(d.beyond)]
    return "".join(f"{cell:>{width}}" for cell, width in zip(cells, _WIDTHS, strict=True))


def _number(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)
