"""`dockloop explain`: the order of stepping, the delay of every connection, the sum over every loop."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from master.coupling.algebraic import algebraic_loops
from master.coupling.ledger import Entry, Ledger
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request, prepare

from .common import INPUTS, JSON, answers_errors, print_json, say, show_building, system_options


@click.command()
@system_options
@INPUTS
@JSON
@answers_errors
def explain(config: Path, as_json: bool, **options: Any) -> None:
    """Say in which order CONFIG steps and how old each value is when it is used."""
    experiment = prepare(config, Request(**options), show_building)
    if as_json:
        print_json(_as_dict(experiment))
        return
    for line in _lines(experiment):
        say(line)


def _as_dict(experiment: Experiment) -> dict[str, Any]:
    ledger = experiment.ledger
    return {
        "name": experiment.name,
        "step_size": experiment.grid.step_size,
        "order": [list(members) for members in experiment.schedule.members],
        "connections": [_entry_dict(e) for e in ledger.entries],
        "loops": [{"path": p.path, "steps": p.steps, "seconds": p.seconds} for p in ledger.loops],
        "loops_complete": ledger.complete,
        "algebraic_loops": [
            {"signals": loop.signals, "solved": loop.is_solved, "explanation": loop.explain()}
            for loop in algebraic_loops(experiment.system, experiment.schedule)
        ],
    }


def _entry_dict(e: Entry) -> dict[str, Any]:
    return {
        "from": e.source,
        "to": e.target,
        "steps": e.mean,
        "least_steps": e.least,
        "most_steps": e.most,
        "seconds": e.seconds,
        "own": [{"kind": o.kind, "seconds": o.seconds, "reason": o.reason} for o in e.own],
    }


def _lines(experiment: Experiment) -> list[str]:
    step = experiment.grid.step_size
    lines = [f"{experiment.name}: one tick is {1e3 * step:g} ms, stepped in this order"]
    for i, group in enumerate(experiment.schedule.groups, start=1):
        rates = [n for n in (experiment.schedule.every[name] for name in group.members) if n > 1]
        lines.append(f"  {i}. {group}" + (f"   every {rates[0]} ticks" if rates else ""))
    lines += ["", "Delay of each connection: age of the value when it is used, and what its target adds"]
    lines += _table(experiment.ledger) + _loop_lines(experiment.ledger)
    algebraic = algebraic_loops(experiment.system, experiment.schedule)
    if algebraic:
        lines += ["", "Algebraic loops: every FMU on them hands the value through at once"]
    return lines + [f"  {loop.explain()}" for loop in algebraic]


def _table(ledger: Ledger) -> list[str]:
    wide = max((len(f"{e.source} -> {e.target}") for e in ledger.entries), default=10) + 2
    head = f"  {'connection':<{wide}}{'steps':>7}{'sum [ms]':>10}   of the target itself"
    rows = []
    for e in ledger.entries:
        steps = f"{e.least}" if e.least == e.most else f"{e.least}..{e.most}"
        own = "; ".join(f"{o.kind} {1e3 * o.seconds:+g} ms ({o.reason})" for o in e.own)
        name = f"{e.source} -> {e.target}"
        rows.append(f"  {name:<{wide}}{steps:>7}{1e3 * e.seconds:>10.3f}   {own}".rstrip())
    return [head, *rows]


def _loop_lines(ledger: Ledger) -> list[str]:
    if not ledger.loops:
        return ["", "No loops."]
    lines = ["", "Loops: the sum of the delays once around"]
    for loop in ledger.loops:
        path = " -> ".join([*loop.path, loop.path[0]])
        lines.append(f"  {loop.steps:g} steps, {1e3 * loop.seconds:.3f} ms: {path}")
    return lines if ledger.complete else [*lines, f"  ... more than {len(ledger.loops)} loops"]
