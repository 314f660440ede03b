"""The declarations of a model: each variable stands once, with unit, start value and rule."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum, IntEnum
from itertools import chain

Scalar = float | int | bool


class Role(Enum):
    """What a variable is to the equations."""

    PARAMETER = "parameter"
    INPUT = "input"
    STATE = "state"
    OUTPUT = "output"


@dataclass(frozen=True, kw_only=True)
class Variable:
    """
    One scalar of a model, SI unit.

    A vector is declared by `vector` and is one `Variable` an element, named `base[i]`, i from 1.
    `sampled` states change in `update`, the others in `derivatives`; a `hidden` one has no FMI variable.
    `output` marks a state that is read from outside as it is. A continuous state that `restarts` begins each
    communication step at its start value.
    """

    name: str
    role: Role
    unit: str
    start: Scalar
    description: str
    minimum: float | None = None
    maximum: float | None = None
    above: float | None = None
    items: type[IntEnum] | None = None
    boolean: bool = False
    integer: bool = False
    fixed: bool = False
    sampled: bool = False
    hidden: bool = False
    restarts: bool = False
    output: bool = False
    nominal: float | None = None

    @property
    def base(self) -> str:
        """Name without index."""
        return self.name.partition("[")[0]

    def broken_rule(self, value: float) -> str | None:
        """Name the rule that the value breaks: `a finite number`, `above 0`, ...; None if it keeps all."""
        if not float("-inf") < value < float("inf"):
            return "a finite number"
        if self.items is not None and value not in {int(item) for item in self.items}:
            return "one of " + ", ".join(f"{item.value} ({item.name})" for item in self.items)
        if self.above is not None and value <= self.above:
            return f"above {self.above!r}"
        if self.minimum is not None and value < self.minimum:
            return f"at least {self.minimum!r}"
        if self.maximum is not None and value > self.maximum:
            return f"at most {self.maximum!r}"
        return None


def parameter(
    name: str,
    start: float,
    unit: str,
    description: str,
    *,
    minimum: float | None = None,
    above: float | None = None,
    maximum: float | None = None,
) -> Variable:
    """Declare a real parameter that may be tuned during a run."""
    return Variable(
        name=name,
        role=Role.PARAMETER,
        unit=unit,
        start=float(start),
        description=description,
        minimum=minimum,
        above=above,
        maximum=maximum,
    )


def fixed(variable: Variable) -> Variable:
    """Make a parameter one that is set before the run and not changed in it."""
    return replace(variable, fixed=True)


def switch(name: str, start: bool, description: str) -> Variable:
    """Declare a Boolean parameter."""
    return Variable(
        name=name, role=Role.PARAMETER, unit="1", start=start, description=description, boolean=True
    )


def choice(name: str, start: IntEnum, description: str) -> Variable:
    """Declare an enumeration parameter; its items are the members of the start value's type."""
    return Variable(
        name=name,
        role=Role.PARAMETER,
        unit="1",
        start=int(start),
        description=description,
        items=type(start),
        integer=True,
        fixed=True,
    )


def whole_number(name: str, start: int, description: str, *, minimum: int, maximum: int) -> Variable:
    """Declare an integer parameter that is set before the run."""
    return Variable(
        name=name,
        role=Role.PARAMETER,
        unit="1",
        start=start,
        description=description,
        minimum=minimum,
        maximum=maximum,
        integer=True,
        fixed=True,
    )


def input_(name: str, unit: str, description: str, start: float = 0.0) -> Variable:
    """Declare a real input."""
    return Variable(name=name, role=Role.INPUT, unit=unit, start=float(start), description=description)


def state(
    name: str,
    unit: str,
    description: str,
    start: float = 0.0,
    *,
    output: bool = False,
    nominal: float | None = None,
) -> Variable:
    """Declare a continuous state."""
    return Variable(
        name=name,
        role=Role.STATE,
        unit=unit,
        start=float(start),
        description=description,
        output=output,
        nominal=nominal,
    )


def sampled(variable: Variable, *, hidden: bool = False) -> Variable:
    """Make a state one that changes at the sampling instants only."""
    return replace(variable, sampled=True, hidden=hidden)


def of_each_step(variable: Variable) -> Variable:
    """Make a continuous state the integral over one communication step, without an FMI variable."""
    return replace(variable, hidden=True, restarts=True)


def output(name: str, unit: str, description: str, *, boolean: bool = False) -> Variable:
    """Declare an output that the equations compute."""
    return Variable(
        name=name,
        role=Role.OUTPUT,
        unit=unit,
        start=False if boolean else 0.0,
        description=description,
        boolean=boolean,
    )


def vector(variable: Variable, n: int) -> tuple[Variable, ...]:
    """Repeat a declaration as `name[1]` to `name[n]`; the equations see one tuple `name`."""
    return tuple(replace(variable, name=f"{variable.name}[{i}]") for i in range(1, n + 1))


def declare(*variables: Variable | Iterable[Variable]) -> tuple[Variable, ...]:
    """Join declarations of scalars and vectors in their order."""
    return tuple(chain.from_iterable([v] if isinstance(v, Variable) else v for v in variables))
