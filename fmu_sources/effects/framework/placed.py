"""An effect in a slot of a model: its names, units and states there."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ...framework.arithmetic import Arithmetic
from ...framework.model import Slot
from ...framework.variables import Variable, sampled, state
from .effect import Applied, Effect
from .roles import Signals, roles, units


@dataclass(frozen=True)
class Placed:
    """An effect in a slot of a model; `home` is the equation that advances its states."""

    slot: Slot
    effect: Effect
    prefix: str
    home: str

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the hidden states that hold the slot over a sampling period, value first."""
        if self.home != "update" or not any(not v.sampled for v in self.effect.states):
            return ()
        return tuple(f"{self.prefix}_held_{name}" for name in ("value", *roles(self.slot)))

    def own(self, names: Sequence[str], record: Any) -> list[Any]:
        """Read the effect's fields from a record of the composed model."""
        return [getattr(record, f"{self.prefix}_{name}") for name in names]

    def apply(self, t: Any, value: Any, s: Signals, x: Any, p: Any, m: Arithmetic) -> Applied:
        """Evaluate the law with records of the composed model."""
        own_x = self.effect.state_record.record(self.own(self.effect.state_record.names, x))
        own_p = self.effect.parameter_record.record(self.own(self.effect.parameter_record.names, p))
        return self.effect.law(t, value, s, own_x, own_p, m)

    def declarations(self, starts: Mapping[str, float]) -> tuple[Variable, ...]:
        """Declarations with full names, the slot's units and other start values."""
        unit = units(self.slot)
        own = [self._named(v, unit, starts) for v in (*self.effect.parameters, *self.effect.states)]
        names = ("value", *roles(self.slot))
        held_units = [self.slot.unit, *(self.slot.signals[n] for n in roles(self.slot).values())]
        hold = [
            sampled(state(f"{self.prefix}_held_{name}", u, f"Held {name} of {self.slot.name}"), hidden=True)
            for name, u in zip(names, held_units, strict=True)
            if self.held
        ]
        return (*own, *hold)

    def _named(self, v: Variable, unit: Mapping[str, str], starts: Mapping[str, float]) -> Variable:
        return replace(
            v,
            name=f"{self.prefix}_{v.name}",
            unit=_filled(v.unit, unit),
            start=float(starts.get(v.name, v.start)),
            description=f"{self.effect.description} in {self.slot.name}: {v.description}",
        )

    def changes(self, applied: Applied, *, is_sampled: bool) -> dict[str, Any]:
        """Changes of the effect's sampled or continuous states, by full name."""
        kinds = {v.name: v.sampled for v in self.effect.states}
        return {
            f"{self.prefix}_{name}": change
            for name, change in applied.changes.items()
            if kinds[name] is is_sampled
        }

    def hold(self, value: Any, s: Signals) -> dict[str, Any]:
        """Values of the hidden states that hold the slot, if it has them."""
        signals = [getattr(s, role) for role in roles(self.slot)]
        return dict(zip(self.held, [value, *signals], strict=True)) if self.held else {}

    def applied_to_held(self, t: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
        """Evaluate the law on what is held."""
        value, *signals = [getattr(x, name) for name in self.held]
        s = Signals(**dict(zip(roles(self.slot), signals, strict=True)))
        return self.apply(t, value, s, x, p, m)


def _filled(template: str, unit: Mapping[str, str]) -> str:
    """Fill in a unit with one slash: `{value}/s` of a value in m/s is `m/s2`, of one in N/m `N/(m s)`."""
    head, *divisors = template.format(**unit).split("/")
    if len(divisors) < 2:
        return "/".join([head, *divisors])
    below = " ".join(_power(symbol, n) for symbol, n in Counter(divisors).items())
    return f"{head}/({below})" if " " in below else f"{head}/{below}"


def _power(symbol: str, n: int) -> str:
    if n == 1:
        return symbol
    return f"{symbol}{n}" if symbol.isalpha() else " ".join([symbol] * n)
