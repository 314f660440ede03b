"""
Classes of effects: a recording shows the class first; a member is named only where it beats the others.

| class | what its members share |
|---|---|
| friction with memory | a force against the motion that builds up along the way |
| memoryless friction | a force against the motion, of the velocity alone |
| stiffness | a force of the position alone |
| periodic along the position | a force that repeats along the position |
| periodic in time | a force that swings in time, at a frequency of its own |
| relaxation | a force that goes with time under an elongation that stays |
| creep | a reading that goes with time under a load that stays |
| lag-like | a signal that comes late, in details of its own |
| zero error | something added, whatever moves |
| limit | a signal that goes no further, or no faster |
| converter | a signal in steps |
| gain | a signal at another size |

Zero errors, limits, gains and what goes with time say so themselves (`Effect.of_class`); the others show it
by what they need.
"""

from __future__ import annotations

from fmu_sources.effects.framework.effect import Effect, FirstGuess
from master.diagnosis.replay.placed_effect import PlacedEffect

MEMORY = "friction with memory"
MEMORYLESS = "memoryless friction"
STIFFNESS = "stiffness"
RIPPLE = "periodic along the position"
LAG_LIKE = "lag-like"
CONVERTER = "converter"
OTHER = "a law of its own"


def class_of(effect: Effect) -> str:
    """Name the class of an effect, from what it declares."""
    if effect.of_class is not None:
        return effect.of_class
    if effect.acts_like is not None:
        return LAG_LIKE
    if effect.first_guess is FirstGuess.QUANTA:
        return CONVERTER
    if effect.first_guess is FirstGuess.PERIODS:
        return RIPPLE
    if "velocity" in effect.needs:
        return MEMORY if effect.has_memory else MEMORYLESS
    if "position" in effect.needs:
        return MEMORY if effect.has_memory else STIFFNESS
    return OTHER


def are_of_a_class(one: PlacedEffect, other: PlacedEffect) -> bool:
    """Whether two effects are of one class, in one slot."""
    kind = class_of(one.law)
    return one.place == other.place and kind == class_of(other.law) != OTHER
