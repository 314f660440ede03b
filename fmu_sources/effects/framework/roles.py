"""
The roles of a slot's signals: an effect asks for a velocity, whatever the slot calls it.

    position   the first signal q that has its rate der_q beside it, or the one that the slot names
    velocity   that der_q, or the first rate there is
    load       the signal `load`: a normal force or band tension
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from ...framework.model import Slot
from .effect import Effect, Place

RATE = "der_"


class Signals(NamedTuple):
    """Signals of a slot by role; None where the slot has none."""

    position: Any = None
    velocity: Any = None
    load: Any = None


def roles(slot: Slot) -> Mapping[str, str]:
    """Map role to the slot's name of the signal."""
    names = list(slot.signals)
    rates = [n for n in names if n.startswith(RATE)]
    found = {}
    positions = [n for n in names if RATE + n in rates]
    if positions:
        found["position"] = positions[0]
        found["velocity"] = RATE + positions[0]
    elif rates:
        found["velocity"] = rates[0]
    if slot.position is not None:
        found.setdefault("position", slot.position)
    if "load" in names:
        found["load"] = "load"
    return found


def by_role(slot: Slot, signals: Mapping[str, Any]) -> Signals:
    """View the signals of a call by their roles."""
    return Signals(**{role: signals[name] for role, name in roles(slot).items()})


def place(slot: Slot) -> Place:
    """Tell a force between bodies from a value on its way."""
    return Place.MECHANICAL if "velocity" in roles(slot) else Place.SIGNAL


def fits(effect: Effect, slot: Slot) -> bool:
    """Say whether the slot has the signals that the effect needs and is a place for it."""
    return place(slot) in effect.places and set(effect.needs) <= set(roles(slot))


def units(slot: Slot) -> Mapping[str, str]:
    """Units that the templates of an effect's declarations may name."""
    found = {role: slot.signals[name] for role, name in roles(slot).items()}
    return {"value": slot.unit, "position": "m", "load": "N"} | found
