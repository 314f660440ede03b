"""
What a model is: variables declared once, and equations in scalar arithmetic.

A step of one sampling period Ts from t to t + Ts, with the inputs u set before it:

    x_sampled     = update(t, x, u, p)          at t
    der(x_cont)   = derivatives(t, x, u, p)     from t to t + Ts, u as `input_hold` says
    y             = outputs(t, x, u, p)         at t + Ts

A model without sampled states has no sampling period and takes any step. Equations see records
`x, u, p` whose fields are the declared names (a vector is a tuple), the mathematics namespace `m`
and `slot`, which lets an effect replace a quantity at a named place. They know no FMI and no master.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from typing import Any, ClassVar

from .arithmetic import Arithmetic
from .records import RecordType
from .variables import Role, Variable

Values = Mapping[str, Any]
SlotFunction = Callable[..., Any]


class InputHold(IntEnum):
    """What a continuous model does with an input between the previous and the present communication point."""

    interpolate = 1
    hold_new = 2
    hold_old = 3


@dataclass(frozen=True)
class Slot:
    """
    A named place in the equations: what stands there, and which signals an effect may use.

    `position` names the signal that a law may take as a position though its rate is not among the signals,
    as the level of a tank, whose rate depends on the outflow in the slot.
    """

    name: str
    unit: str
    description: str
    signals: Mapping[str, str] = field(default_factory=dict)
    position: str | None = None


@dataclass(frozen=True)
class Terminal:
    """Variables that are plugged in together: member name to variable name (FMI 3.0 terminals)."""

    name: str
    kind: str
    description: str
    members: Mapping[str, str]


@dataclass(frozen=True)
class Delay:
    """
    A delay that a model adds between an input and its outputs, for the master's delay ledger.

    `steps` counts communication steps (negative: the model uses the value as one of an earlier
    instant of its step); with `by`, the name of a choice, it is a mapping from item to steps.
    `seconds` is a number or the name of the parameter that holds it.
    """

    input: str
    kind: str
    steps: float | Mapping[str, float] = 0.0
    by: str | None = None
    seconds: float | str = 0.0
    reason: str = ""


@dataclass(frozen=True)
class Linear:
    """
    A parameter's value with which the model is linear and constant in time, for an analysis.

    `value` is a number or an item of a choice; `reason` says what the analysis then leaves out. With another
    value the model varies with time if it names a `frequency`: the parameter [Hz] by which it repeats itself.
    """

    parameter: str
    value: float | str
    reason: str
    frequency: str | None = None


@dataclass(frozen=True)
class Learning:
    """With the item of the choice `by` the model learns as it runs, until the Boolean `held_by` is set."""

    by: str
    item: str
    held_by: str


@dataclass(frozen=True)
class Fault:
    """What ends a run: the variable whose value shows it, what is wrong, what is expected of the value."""

    variable: str
    text: str
    expected: str


def no_effect(name: str, value: Any, **signals: Any) -> Any:
    """Leave what stands in the slot."""
    return value


class Model:
    """
    Base of every model; a subclass declares the class attributes and overrides the equations it has.

    `substep` [s] is the longest step of the integration. `accuracy` is the largest error of the outputs with
    it, relative to the largest value of each; None where it is that of the arithmetic or of slow equations.
    """

    name: ClassVar[str]
    description: ClassVar[str]
    variables: ClassVar[tuple[Variable, ...]]
    slots: ClassVar[tuple[Slot, ...]] = ()
    delays: ClassVar[tuple[Delay, ...]] = ()
    linear: ClassVar[tuple[Linear, ...]] = ()
    learning: ClassVar[tuple[Learning, ...]] = ()
    terminals: ClassVar[tuple[Terminal, ...]] = ()
    fault_texts: ClassVar[tuple[Fault, ...]] = ()
    sample_time: ClassVar[str | None] = None
    input_hold: ClassVar[str | None] = None
    substep: ClassVar[float] = 0.2e-3
    accuracy: ClassVar[float | None] = None

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        """States that follow from inputs and parameters at the start; the others keep their start value."""
        return {}

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        """Sampled states after the sampling instant t; states that are not named keep their value."""
        return {}

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        """Time derivatives of all continuous states."""
        return {}

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        """All outputs that are not states."""
        return {}

    def faults(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic) -> Sequence[Any]:
        """
        Conditions that end the run, in the order of `fault_texts`: true or not zero is a fault.

        They are looked at after each sampling period of a communication step.
        """
        return ()

    def group(self, role: Role) -> tuple[Variable, ...]:
        """Variables of one role in declared order; continuous states stand before sampled ones."""
        chosen = [v for v in self.variables if v.role is role]
        return tuple(sorted(chosen, key=lambda v: v.sampled))

    @cached_property
    def parameters(self) -> RecordType:
        """Record of the parameters."""
        return RecordType("parameters", self.group(Role.PARAMETER))

    @cached_property
    def inputs(self) -> RecordType:
        """Record of the inputs."""
        return RecordType("inputs", self.group(Role.INPUT))

    @cached_property
    def states(self) -> RecordType:
        """Record of the states, continuous ones first."""
        return RecordType("states", self.group(Role.STATE))

    @cached_property
    def continuous(self) -> RecordType:
        """Record of the continuous states alone, the shape of `derivatives`."""
        return RecordType("derivatives", self.group(Role.STATE)[: self.n_continuous])

    @cached_property
    def results(self) -> RecordType:
        """Record of the computed outputs."""
        return RecordType("outputs", self.group(Role.OUTPUT))

    @cached_property
    def n_continuous(self) -> int:
        """Number of continuous states."""
        return sum(not v.sampled for v in self.group(Role.STATE))

    @cached_property
    def all_variables(self) -> Sequence[Variable]:
        """Parameters, inputs, states, outputs: the place here is the FMI value reference."""
        return [v for role in Role for v in self.group(role)]
