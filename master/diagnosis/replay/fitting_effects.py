"""Which effects of the library fit the slots of a part."""

from __future__ import annotations

from collections.abc import Mapping

from fmu_sources.effects import catalogue as library
from master.diagnosis.case.cut import CutPart, CutSystem
from master.text.signal_name import SignalName

from .placed_effect import PlacedEffect


def candidates(system: CutSystem, part: CutPart, asked: Mapping[str, str | list[str]]) -> list[PlacedEffect]:
    """
    List the effects of the library that fit slots of a part.

    Args:
        system: The system.
        part: The part.
        asked: `fmu.slot` to "all" or to names of effects that fit it, as checked with the case; where an FMU
            has none, all slots of its equations are searched.
    """
    effects = []
    for fmu in part.fmus:
        model = system.model(fmu)
        slots = system.slots(fmu)
        chosen = {SignalName(k).variable: v for k, v in asked.items() if SignalName(k).instance == fmu}
        if not chosen and model is not None:
            chosen = {slot.name: "all" for slot in model.slots}
        for slot, names in chosen.items():
            laws = library.candidates(slots[slot]) if names == "all" else [library.effect(n) for n in names]
            effects += [PlacedEffect(fmu, slot, law.name) for law in laws]
    return effects
