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
from .common import NEVER, SMALLEST_SHARE, SMALLEST_SMOOTHING, SMOOTHING
from .experiment import Experiment
from .limit import Limit
from .rms import Rms as Rms  # a part of what an effect is, found here as well


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


class FirstGuess(Enum):
    """Where a fit of a law begins."""

    MULTIPLES = "at multiples of its scales"
    QUANTA = "at steps that the recorded value is made of"
    PERIODS = "at periods along the position that the residual shows"
    FREQUENCIES = "at frequencies at which the residual shows the position modulated in time"


Law = Callable[[Any, Any, Any, Any, Any, Arithmetic], Applied]


@dataclass(frozen=True, kw_only=True)
class Effect:
    """
    One law with its declarations, and all that is known of it.

    Units may name the slot's own: `{value}`, `{position}`, `{load}`. `absent` makes the law do nothing.
    `scale` gives the typical magnitude of each parameter; `held` ones stay there in a fit. `variants` are
    start values of which a fit tries all, where the law has a side; `first_guess` says where it begins.
    `probe` is the share of the typical amplitudes at which the law answers in proportion; 1 for one that does
    nothing below. `follows` names the states that start at the slot's value, as a filter at rest does.
    `equals_sum_of` names effects that together make this law or nearly; `limits` says what it becomes at the
    ends of its parameters. Effects with the same `acts_like` differ in details that models get wrong, too.
    `shown_by` names recordings that tell it from others. `constant` is the parameter that the law adds to the
    value as it is, where it does nothing else. `of_class` names the class that a recording shows first, where
    the other declarations do not.
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
    variants: tuple[Mapping[str, float], ...] = field(default=({},))
    first_guess: FirstGuess = FirstGuess.MULTIPLES
    probe: float = 0.02
    equals_sum_of: tuple[str, ...] = ()
    limits: tuple[Limit, ...] = ()
    acts_like: str | None = None
    shown_by: tuple[Experiment, ...] = ()
    constant: str | None = None
    of_class: str | None = None

    @property
    def has_memory(self) -> bool:
        """Whether what the law gives depends on more than the present signals."""
        return bool(self.states)

    def limit(self, values: Mapping[str, float], rms: Rms) -> Limit | None:
        """Find the limit that parameters are at, by their short names; None if they are at none."""
        return next((limit for limit in self.limits if limit.is_reached(values, rms)), None)

    @cached_property
    def amplitudes(self) -> tuple[str, ...]:
        """Names of the fitted parameters that the law is linear in; the others are its shapes."""
        return tuple(v.name for v in self.parameters if v.name in self.fitted and self._is_amplitude(v))

    def _is_amplitude(self, v: Variable) -> bool:
        absent = self.absent.get(v.name)
        if absent == NEVER or v.unit in ("{position}", "s"):
            return False
        return absent == 0.0 or "{value}" in v.unit

    @staticmethod
    def smallest_share(name: str) -> float:
        """Share of its scale below which a fit leaves no positive parameter: for the integrator."""
        return SMALLEST_SMOOTHING if name == SMOOTHING else SMALLEST_SHARE

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
