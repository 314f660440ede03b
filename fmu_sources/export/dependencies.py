"""Which inputs and parameters the initial values hang on, found by sending labels through the equations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from ..framework.model import Model
from ..framework.variables import Role


class Label:
    """A number that only remembers the names it came from."""

    __slots__ = ("names",)

    def __init__(self, names: frozenset[str] = frozenset()) -> None:
        self.names = names

    def _join(self, other: Any = None) -> Label:
        return Label(self.names | names_of(other))

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = _join
    __truediv__ = __rtruediv__ = __pow__ = _join
    __lt__ = __le__ = __gt__ = __ge__ = _join
    __eq__ = __ne__ = _join  # type: ignore[assignment]
    __hash__ = None  # type: ignore[assignment]

    def __neg__(self) -> Label:
        return self

    __pos__ = __abs__ = __neg__

    def __bool__(self) -> bool:
        raise TypeError("the equations branch on a signal; use m.where")


def names_of(value: Any) -> frozenset[str]:
    """Names that a result hangs on; none for a plain number."""
    return value.names if isinstance(value, Label) else frozenset()


def _joined(*values: Any) -> Label:
    return Label(frozenset().union(*map(names_of, values)))


class LabelArithmetic:
    """The mathematics namespace on labels."""

    pi = math.pi
    sqrt = exp = log = sin = cos = tan = tanh = floor = fabs = staticmethod(_joined)
    where = both = staticmethod(_joined)

    @staticmethod
    def pick(values: Sequence[Any], index: Any) -> Label:
        """Hang on the index and on every element."""
        return _joined(index, *values)


def initial_dependencies(model: Model) -> dict[str, list[str]]:
    """Map each variable that is calculated at the start to the variables it hangs on, in declared order."""
    m = LabelArithmetic()
    p, u, x = (
        kind.record([Label(frozenset({name})) for name in kind.names])
        for kind in (model.parameters, model.inputs, model.states)
    )
    names = model.states.names
    starts = model.initial(x, u, p, m)
    merged = model.states.merged(starts, [Label(frozenset({n})) for n in names])
    calculated = {n: names_of(v) for n, v in zip(names, merged, strict=True) if names_of(v) != {n}}
    if len(model.results):
        y = model.outputs(Label(), model.states.record(merged), u, p, m)
        flat = model.results.flat(y)
        calculated |= {n: names_of(v) for n, v in zip(model.results.names, flat, strict=True)}
    order = [v.name for v in model.all_variables if v.role is not Role.OUTPUT and not v.hidden]
    return {name: [n for n in order if n in found] for name, found in calculated.items()}


def influences(model: Model) -> dict[str, list[str]]:
    """Map each output to the inputs that reach it sooner or later, through states of any kind."""
    m = LabelArithmetic()
    p = model.parameters.record([Label()] * len(model.parameters))
    u = model.inputs.record([Label(frozenset({name})) for name in model.inputs.names])
    labels = [Label()] * len(model.states)
    n = model.n_continuous
    while True:
        x = model.states.record(labels)
        rates = model.continuous.flat(model.derivatives(Label(), x, u, p, m)) if n else []
        grown = [_joined(a, b) for a, b in zip(labels, rates, strict=False)] + labels[n:]
        updated = model.states.merged(model.update(Label(), x, u, p, m), grown)
        new = [_joined(a, b) for a, b in zip(grown, updated, strict=True)]
        if [a.names for a in new] == [b.names for b in labels]:
            break
        labels = new
    found = dict(zip(model.states.names, labels, strict=True))
    if len(model.results):
        y = model.results.flat(model.outputs(Label(), x, u, p, m))
        found |= {name: _joined(value) for name, value in zip(model.results.names, y, strict=True)}
    shown = [v.name for v in model.all_variables if v.role is Role.OUTPUT or v.output]
    return {name: [i for i in model.inputs.names if i in found[name].names] for name in shown}
