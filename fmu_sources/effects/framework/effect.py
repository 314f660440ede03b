"""
What an effect is: a law that a model may lack, with parameters and states of its own.

A law sees what stands in a slot and the slot's signals by role, and gives what shall stand there:

    law(t, value, s, x, p, m) -> Applied(new value, changes of its states, signals for later effects)

It is scalar arithmetic on the namespace `m`, like the equations of a model. A force counts positive where it
resists: with the sign of the spring and damper forces k * position and c * velocity.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import Any, NamedTuple

from ...framework.arithmetic import Arithmetic
from ...framework.records import RecordType
from ...framework.variables import Variable


class Place(Enum):
    """Where a law makes sense."""

    MECHANICAL = "a force between bodies, with a position and its rate"
    SIGNAL = "a value on its way: a sensor's output, a command"


EVERYWHERE = frozenset(Place)
MECHANICAL = frozenset({Place.MECHANICAL})
SIGNAL = frozenset({Place.SIGNAL})


class Applied(NamedTuple):
    """
    What a law gives.

    `changes` are time derivatives of continuous states and next values of sampled ones; `signals` replace
    roles for the effects that come later in the same slot.
    """

    value: Any
    changes: Mapping[str, Any] = {}
    signals: Mapping[str, Any] = {}


@dataclass(frozen=True, kw_only=True)
class Rms:
    """Size of a slot's value and signals in a recording, for scaling a fit."""

    value: float = 1.0
    position: float = 1.0
    velocity: float = 1.0
    load: float = 1.0
    duration: float = 1.0


Law = Callable[[Any, Any, Any, Any, Any, Arithmetic], Applied]


@dataclass(frozen=True, kw_only=True)
class Effect:
    """
    One law with its declarations.

    Units may name the slot's own: `{value}`, `{position}`, `{load}`. `absent` makes the law do nothing.
    `scale` gives the typical magnitude of each parameter; `held` ones stay there in a fit. `variants` are
    start values of which a fit tries all, where the law has a side. `follows` names the states that start at
    the slot's value, as a filter at rest does. `made_of` names effects that together make this law or nearly.
    """

    name: str
    description: str
    law: Law
    parameters: tuple[Variable, ...]
    absent: Mapping[str, float]
    scale: Callable[[Rms], Mapping[str, float]]
    states: tuple[Variable, ...] = ()
    needs: tuple[str, ...] = ()
    places: frozenset[Place] = EVERYWHERE
    held: tuple[str, ...] = ()
    follows: tuple[str, ...] = ()
    made_of: tuple[str, ...] = ()
    variants: tuple[Mapping[str, float], ...] = field(default=({},))

    @cached_property
    def fitted(self) -> tuple[str, ...]:
        """Names of the parameters that a fit changes."""
        sides = {name for variant in self.variants for name in variant}
        return tuple(v.name for v in self.parameters if v.name not in {*self.held, *sides})

    @cached_property
    def parameter_record(self) -> RecordType:
        """Record of the parameters by their short names."""
        return RecordType("effect_parameters", self.parameters)

    @cached_property
    def state_record(self) -> RecordType:
        """Record of the states by their short names."""
        return RecordType("effect_states", self.states)
