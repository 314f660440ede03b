"""
Composed models by name, for a system file that asks for one.

    docking_contact__rope_force_slack_and_guide_force_coulomb
    base             slot and effect        slot and effect
"""

from __future__ import annotations

from collections.abc import Callable

from ..effects.catalogue import effect, file_of
from ..effects.framework.effect import Effect
from ..framework.model import Model
from .composition import AND, SEPARATOR, all_slots, with_effect


def is_composed(name: str) -> bool:
    """Whether a name is that of a model with effects."""
    return SEPARATOR in name


def base_of(name: str) -> str:
    """Name of the model before effects."""
    return name.partition(SEPARATOR)[0]


def effects_of(name: str, load: Callable[[str], Model]) -> list[str]:
    """Files of the effects that a name asks for, without ending; ValueError if a part is none."""
    base = load(base_of(name))
    return [file_of(_parts(base, part)[1].name) for part in _rest(name)]


def composed(name: str, load: Callable[[str], Model]) -> Model:
    """
    Make the model that a name describes, effects at their own start values.

    Args:
        name: As `with_effect` gives it, with its own prefixes.
        load: Finds the base by name.

    Raises:
        ValueError: If a part is no slot and effect of the base.
    """
    model = base = load(base_of(name))
    for part in _rest(name):
        slot, found = _parts(base, part)
        model = with_effect(model, slot, found)
    return model


def _rest(name: str) -> list[str]:
    return name.partition(SEPARATOR)[2].split(AND)


def _parts(base: Model, part: str) -> tuple[str, Effect]:
    for slot in sorted((s.name for s in all_slots(base)), key=len, reverse=True):
        if part.startswith(slot + "_"):
            try:
                return slot, effect(part[len(slot) + 1 :])
            except KeyError:
                continue
    known = [s.name for s in all_slots(base)]
    raise ValueError(
        f"{base.name}: no such slot and effect, got {part!r}, expected <slot>_<effect>, slots {known}"
    )
