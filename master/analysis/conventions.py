"""
Names of parameters by which FMUs say that they are not linear, or vary with time, and how to make them so.

The analysis measures an FMU by its responses, and these cannot tell it that an FMU learns from its inputs, or
after how long it repeats itself. Whoever knows the models says so: `master.docking.conventions` for those of
this project.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from master.fmi.values import parse
from master.system.graph import Instance


@dataclass(frozen=True)
class Assumed:
    """A value that the analysis gives to a parameter, and why."""

    parameter: str
    value: str | float
    reason: str


@dataclass(frozen=True)
class Learning:
    """
    FMUs that learn from their inputs while they run.

    `hold` is the Boolean parameter that stops it during a run; with the parameter and value of `off` an FMU
    does not learn at all. `when_held` and `when_off` say what is then assumed.
    """

    hold: str
    off: tuple[str, str]
    when_held: str
    when_off: str


@dataclass(frozen=True)
class Varying:
    """A parameter that makes an FMU vary with time, that of its frequency [Hz], and what 0 assumes."""

    amplitude: str
    frequency: str
    reason: str


@dataclass(frozen=True)
class Conventions:
    """All that is known of the FMUs by the names of their parameters; nothing by default."""

    learning: Learning | None = None
    varying: tuple[Varying, ...] = ()

    def learns(self, instance: Instance) -> bool:
        """Whether an FMU learns, and can be told to stop."""
        if self.learning is None or self.learning.hold not in instance.description.by_name:
            return False
        return instance.value_of(self.learning.hold) == 0.0 and not self._is_off(instance, self.learning)

    def _is_off(self, instance: Instance, learning: Learning) -> bool:
        parameter, value = learning.off
        variable = instance.description.by_name.get(parameter)
        return variable is not None and instance.value_of(parameter) == parse(variable, value)

    def holding(self, instance: Instance) -> Instance:
        """Tell an FMU that learns not to, from its start."""
        if self.learning is None:
            return instance
        return replace(instance, start={**instance.start, self.learning.hold: 1.0})

    @property
    def assumed(self) -> tuple[Assumed, ...]:
        """Values with which the FMUs are linear and constant."""
        found = [] if self.learning is None else [Assumed(*self.learning.off, self.learning.when_off)]
        return (*found, *(Assumed(v.amplitude, 0.0, v.reason) for v in self.varying))
