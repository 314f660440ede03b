"""What the design of a phase lead (DPDC) needs of a system; checked without stepping it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

from master.errors import ConfigError, Problem, nearest
from master.fmi.values import parse
from master.system.config import Compare, PhaseLead
from master.system.graph import Instance, System, Wire

PARAMETERS = ("dpdc_phase", "dpdc_frequency", "dpdc_gain")
ATTRIBUTES = ("m_s", "m_e", "k_m", "k_p")

Span = tuple[float, float]
"""Least and largest value."""


@dataclass(frozen=True)
class LeadTask:
    """
    The design to do: from the wire of the simulated motion to the reproduced one.

    `spans` are least and largest m_s [kg], m_e [kg], k_m [N/m], k_p [N/m], in this order.
    """

    fmu: str
    wire: Wire
    reproduced: str
    spans: tuple[Span, Span, Span, Span]


def lead_task(system: System, compare: Compare | None, wish: PhaseLead, where: str = "dpdc") -> LeadTask:
    """
    Check a wish for a phase lead against its system; `where` is its place in the file.

    Raises:
        ConfigError: With all that the system lacks.
    """
    problems: list[Problem] = []

    def add(what: str, got: str, expected: str, at: str = where) -> None:
        problems.append(Problem(what, where=at, got=got, expected=expected))

    reproduced = None if compare is None else compare.reproduced
    if reproduced is None:
        add("no motions to compare", "no compare.reproduced", "one")
    instance = system.instances.get(wish.fmu)
    if instance is None:
        add("no such FMU", repr(wish.fmu), nearest(wish.fmu, system.instances), f"{where}.fmu")
    if instance is None or compare is None or reproduced is None:
        raise ConfigError(problems)
    missing = _missing(instance, wish)
    if missing:
        add(f"no phase lead in {wish.fmu}", f"no {', '.join(missing)}", "all")
    into = [w for w in system.wires_into(wish.fmu) if w.source.name == compare.signal]
    if not into:
        add("not connected", f"no {compare.signal} -> {wish.fmu}", "one")
    if wish.amplitude == "plant" and _has_another_gain(instance):
        got = f"{wish.amplitude} and another {wish.fmu}.gain_convention than paper"
        add("two rules for one gain", got, "one of them to be paper", f"{where}.amplitude")
    spans = _spans(wish, system.instances.get(compare.signal.instance), instance)
    for key in ATTRIBUTES:
        if not _is_range(spans[key]):
            add(f"no range of {key}", str(spans[key]), "positive least and largest")
    if problems:
        raise ConfigError(problems)
    whole = cast("tuple[Span, Span, Span, Span]", tuple(spans.values()))
    return LeadTask(wish.fmu, into[0], reproduced, whole)


def is_switched_off(system: System, wish: PhaseLead) -> bool:
    """Whether the compensator does not use a phase lead."""
    compensator = system.instances.get(wish.fmu)
    return compensator is not None and compensator.value_of("dpdc") == 0.0


def _missing(instance: Instance, wish: PhaseLead) -> list[str]:
    """Parameters of a phase lead that an FMU does not have."""
    needed = PARAMETERS if wish.amplitude == "plant" else PARAMETERS[:2]
    return [name for name in ("dpdc", *needed) if name not in instance.description.by_name]


def _has_another_gain(instance: Instance) -> bool:
    convention = instance.description.by_name.get("gain_convention")
    return convention is not None and instance.value_of("gain_convention") != parse(convention, "paper")


def _spans(wish: PhaseLead, spacecraft: Instance | None, compensator: Instance) -> dict[str, Span | None]:
    ranges: dict[str, Span] = {str(key): span for key, span in wish.ranges.items()}
    return {key: _span(spacecraft if key == "m_s" else compensator, ranges, key) for key in ATTRIBUTES}


def _is_range(span: Span | None) -> bool:
    return span is not None and 0.0 < span[0] <= span[1] and math.isfinite(span[1])


def _span(owner: Instance | None, ranges: Mapping[str, Span], key: str) -> Span | None:
    if key in ranges:
        return ranges[key]
    own = None if owner is None else owner.value_of(key)
    return (own, own) if isinstance(own, float) else None
