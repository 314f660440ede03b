"""
A first system file from FMUs: connections guessed by terminals, names and units, every guess marked.

A guess is never made from the unit alone where there are two that fit; what stays open is listed.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from graphlib import CycleError, TopologicalSorter

from master.fmi.description import Description, Kind, Variable
from master.fmi.inspection import Inspection
from master.fmi.units import conversion
from master.text.signal_name import SignalName

_ALIKE = 0.6  # least likeness of two names that are taken for one quantity
_SHORTEST = 3  # characters
_STEP_SIZE = 1e-3  # s
_N_STEPS = 1000
_MOST_SHOWN = 6


@dataclass(frozen=True)
class Part:
    """An FMU of the draft: how the file names it, what it says of itself."""

    source: str
    description: Description
    inspection: Inspection


@dataclass(frozen=True)
class Guess:
    """A connection, and why."""

    source: str
    target: str
    why: str


def draft(name: str, parts: Mapping[str, Part]) -> list[str]:
    """
    Write the lines of a system file.

    Args:
        name: Name of the system.
        parts: Its FMUs by instance name.
    """
    guesses = list(guess_connections(parts))
    step_size, stop_time, why = _times(parts)
    lines = [
        "# A draft by `dockloop new`: each `guess` is one. `dockloop check` says what is wrong.",
        f"name: {json.dumps(name)}",
        f"step_size: {step_size!r}    # s, guess: {why}",
        f"stop_time: {stop_time!r}    # s, guess: {why}",
        "fmus:",
    ]
    for instance, part in parts.items():
        lines.append(f"  {json.dumps(instance)}: {{source: {json.dumps(part.source)}}}")
    lines += [_order(parts, guesses)]
    lines += ["connections:"] if guesses else ["connections: []"]
    for guess in guesses:
        wire = f"{{from: {json.dumps(guess.source)}, to: {json.dumps(guess.target)}}}"
        lines.append(f"  - {wire}    # guess: {guess.why}")
    return lines + list(_open_ends(parts, guesses))


def guess_connections(parts: Mapping[str, Part]) -> Iterator[Guess]:
    """Guess a source for each input that has a likely one."""
    plugged = {guess.target: guess for guess in _by_terminals(parts)}
    for instance, part in parts.items():
        for variable in _inputs(part):
            target = f"{instance}.{variable.name}"
            guess = plugged.get(target) or _by_name(target, instance, variable, parts)
            if guess is not None:
                yield guess


def _by_terminals(parts: Mapping[str, Part]) -> Iterator[Guess]:
    """Join terminals of one kind that two FMUs have, member by member."""
    plugs = [
        (instance, kind, members)
        for instance, part in parts.items()
        for terminal, members in part.inspection.terminals.items()
        if (kind := part.inspection.terminal_kinds.get(terminal))
    ]
    for instance, kind, members in plugs:
        others = [(i, m) for i, k, m in plugs if k == kind and i != instance]
        if len(others) != 1:
            continue
        other, their_members = others[0]
        for member, name in members.items():
            pair = their_members.get(member)
            mine = parts[instance].description.by_name.get(name)
            theirs = parts[other].description.by_name.get(pair or "")
            if mine is None or theirs is None or theirs.causality != "output" or mine.causality != "input":
                continue
            if _fits(theirs, mine):
                source = f"{other}.{theirs.name}"
                yield Guess(source, f"{instance}.{name}", f"terminals of kind {kind}, member {member}")


def _by_name(target: str, instance: str, variable: Variable, parts: Mapping[str, Part]) -> Guess | None:
    """Take the output of another FMU whose name is most like the input's, if one is alone the nearest."""
    found = sorted(
        (
            (_likeness(output.name, variable.name), f"{other}.{output.name}", output)
            for other, output in _candidates(instance, variable, parts)
        ),
        key=lambda one: -one[0],
    )
    if not found:
        return None
    likeness, source, output = found[0]
    is_alone = len(found) == 1 or found[1][0] < likeness
    has_unit = output.unit is not None and variable.unit is not None
    if not is_alone or likeness < _ALIKE:
        if len(found) == 1 and has_unit:
            return Guess(source, target, f"the only output in {output.unit_name}")
        return None
    unit = f"unit {output.unit_name}" if has_unit else "no unit to compare"
    name = "same name" if output.name == variable.name else f"names alike by {100 * likeness:.0f} %"
    return Guess(source, target, f"{name}, {unit}")


def _candidates(
    instance: str, variable: Variable, parts: Mapping[str, Part]
) -> Iterator[tuple[str, Variable]]:
    for other, part in parts.items():
        if other != instance:
            yield from ((other, v) for v in part.description.outputs if _fits(v, variable))


def _fits(source: Variable, target: Variable) -> bool:
    if Kind.STRING in (source.kind, target.kind) or (source.kind is Kind.REAL) != (target.kind is Kind.REAL):
        return False
    return conversion(source.unit, target.unit) is not None


def _likeness(one: str, other: str) -> float:
    if one == other:
        return 1.0
    if min(len(one), len(other)) < _SHORTEST:  # in short names chance is larger than meaning
        return 0.0
    return SequenceMatcher(None, one.lower(), other.lower()).ratio()


def _inputs(part: Part) -> list[Variable]:
    return [v for v in part.description.variables if v.causality == "input" and v.alias_of is None]


def _order(parts: Mapping[str, Part], guesses: Sequence[Guess]) -> str:
    """Line that says in which order the FMUs step: as they were given, where a loop asks for one."""
    sources = {name: {SignalName(g.source).instance for g in guesses if _ends_at(g, name)} for name in parts}
    try:
        TopologicalSorter(sources).prepare()
    except CycleError:
        order = json.dumps(list(parts))
        return f"coupling: {{order: {order}}}    # guess: as they were given; it sets the delays"
    return "# coupling: {order: [...]}    # none is needed: without loops they step along the connections"


def _ends_at(guess: Guess, instance: str) -> bool:
    return SignalName(guess.target).instance == instance


def _times(parts: Mapping[str, Part]) -> tuple[float, float, str]:
    """Step size and stop time [s] that the FMUs' default experiments name."""
    steps = []
    stops = []
    for part in parts.values():
        steps.append(_number(part.inspection.capabilities.get("stepSize")))
        stops.append(_number(part.inspection.capabilities.get("stopTime")))
    known_steps = [s for s in steps if s]
    known_stops = [s for s in stops if s]
    step_size = min(known_steps, default=_STEP_SIZE)
    stop_time = max(known_stops, default=_N_STEPS * step_size)
    ticks = max(1, round(stop_time / step_size))
    why = "default experiments of the FMUs" if known_steps or known_stops else "no FMU names one"
    return step_size, ticks * step_size, why


def _number(text: object) -> float:
    try:
        return max(0.0, float(str(text)))
    except ValueError:
        return 0.0


def _open_ends(parts: Mapping[str, Part], guesses: list[Guess]) -> Iterator[str]:
    """Say which inputs have no source, with what would fit."""
    taken = {guess.target for guess in guesses}
    for instance, part in parts.items():
        for variable in _inputs(part):
            target = f"{instance}.{variable.name}"
            if target in taken:
                continue
            fitting = [f"{other}.{v.name}" for other, v in _candidates(instance, variable, parts)]
            shown = ", ".join(fitting[:_MOST_SHOWN]) + (", ..." if len(fitting) > _MOST_SHOWN else "")
            yield f"# not connected: {target} [{variable.unit_name}]; outputs that fit: {shown or 'none'}"
