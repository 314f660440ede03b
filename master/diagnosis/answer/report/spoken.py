"""What an engineer would say first: what is missing, how large, and what that leaves of the noise floor."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fmu_sources.effects.catalogue import effect
from master.pages.render import number

Units = Mapping[str, str]
Report = Mapping[str, Any]

_PEOPLE = ("Coulomb",)
_SURE = ("traced", "one of a class")
NO_NUMBER = "has no number"
MOST_VALUES = 3  # of a law in the sentence
_HEADINGS = ("Parameters", "Source", "Limits", "State", "States", "Deviation", "Inputs", "Slots")


@dataclass(frozen=True)
class Law:
    """
    The equation of an effect as its file has it, and its parameters: name, meaning, value, how it is known.

    `name` is the effect in its place, `fmu.slot: effect`.
    """

    name: str
    title: str
    equation: str
    values: Sequence[Sequence[str]]


def first_sentence(report: Report, units: Units) -> str:
    """Say what is missing and what is left, each number with its unit, errors also in noise floors."""
    what = _missing(report, units)
    left = " ".join(_left(report, units))
    return f"{what} {left}".strip()


def laws(report: Report, units: Units) -> list[Law]:
    """Return the law of each effect that was added, as an equation with its values."""
    return [_law(own, report, units) for own in report["effects"]]


def _missing(report: Report, units: Units) -> str:
    effects = report["effects"]
    if not effects:
        return "No law was added to the model."
    sure = [own for own in effects if own["status"] in _SURE]
    if sure:
        return f"The model lacks {' and '.join(_told(own, report, units) for own in sure)}."
    named = " and ".join(_told(own, report, units) for own in effects)
    return f"No law is sure; the nearest is {named} ({effects[0]['status']})."


def _told(own: Mapping[str, Any], report: Report, units: Units) -> str:
    """An effect with its first values and its place."""
    values = [f"{name} {shown}" for name, _, shown, _ in _law(own, report, units).values if shown]
    numbers = f" ({', '.join(values[:MOST_VALUES])})" if values else ""
    return f"{_within(effect(own['effect']).description)}{numbers} in {own['fmu']}.{own['slot']}"


def _within(text: str) -> str:
    """Put a text within a sentence: a first word that is a person's name keeps its capital."""
    return text if text.startswith(_PEOPLE) else text[:1].lower() + text[1:]


def _left(report: Report, units: Units) -> Iterator[str]:
    """Say the error of each signal that an effect has changed, else of the one that is worst explained."""
    known = [
        name
        for name, before in report["before"].items()
        if None not in (before["rmse"], report["after"][name]["rmse"])
    ]
    changed = [
        name for name in known if report["effects"] and report["before"][name] != report["after"][name]
    ]
    worst = sorted(known, key=lambda name: -report["after"][name]["rmse"] / (_floor(report, name) or 1e300))
    for signal in changed or worst[:1]:
        before, after = report["before"][signal]["rmse"], report["after"][signal]["rmse"]
        unit = units.get(signal, "")
        times = _times(before, after, _floor(report, signal), unit, changed=bool(changed))
        off = f"On rows that nothing was fitted to, {signal} is off by {number(after, 3)} {unit} rms"
        yield (
            f"{off} with it, and by {number(before, 3)} {unit} without{times}."
            if changed
            else f"{off}{times}."
        )


def _floor(report: Report, signal: str) -> float | None:
    """Noise floor of a signal in its unit, if one is known."""
    floor = report["channels"].get(signal, {}).get("noise_floor")
    return None if floor is None else float(floor)


def _times(before: float, after: float, floor: float | None, unit: str, *, changed: bool) -> str:
    """Errors as multiples of the noise floor, where one is known."""
    if not floor:
        return ""
    shown = number(after / floor, 3)
    if changed:
        shown += f" and {number(before / floor, 3)}"
    return f": {shown} times the noise floor of {number(floor, 2)} {unit}".rstrip()


def _law(own: Mapping[str, Any], report: Report, units: Units) -> Law:
    added = effect(own["effect"])
    begin = f"{own['fmu']}.{own['slot']}_{own['effect']}_"
    rows = []
    for v in added.parameters:
        fitted = report["parameters"].get(begin + v.name)
        value = own["parameters"].get(v.name)
        if fitted is not None and fitted["with_effect"] is not None:
            value = fitted["with_effect"]
        shown = "" if value is None else number(value)
        if fitted is not None and fitted["no_number"]:
            shown = NO_NUMBER
        elif fitted is not None and fitted["deviation"] is not None:
            shown += f" ± {number(fitted['deviation'], 2)}"
        unit = units.get(begin + v.name, "1")
        if shown not in ("", NO_NUMBER) and unit not in ("1", ""):
            shown += f" {unit}"
        rows.append([v.name, v.description, shown, "fitted" if fitted is not None else "held"])
    place = f"{own['fmu']}.{own['slot']}"
    name = f"{place}: {own['effect']}"
    return Law(name, f"{added.description} in {place}", equation_of(own["effect"]), rows)


def equation_of(name: str) -> str:
    """Return the equations in the text of an effect's file; empty where there is no file."""
    try:
        text = inspect.getdoc(importlib.import_module(f"fmu_sources.effects.{name}")) or ""
    except ModuleNotFoundError:  # a law that was learned has no file
        return ""
    above: list[str] = []
    for line in text.splitlines():
        if line.startswith(_HEADINGS):
            break
        above.append(line)
    return "\n".join(line[4:] for line in above if line.startswith("    "))
