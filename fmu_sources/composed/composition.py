"""
A model with effects in its slots: a new model, exported like any other.

    with_effect(docking_contact, "rope_force", slack)  ->  docking_contact__rope_force_slack

The effect's parameters and states join the model's as `<prefix>_<name>`, the prefix being `<slot>_<effect>`.
The base's equations stay untouched: they call `slot(name, value, **signals)`, and the effects answer in the
order in which they were added. The states of an effect change with the equation that owns the slot, its home:

    derivatives   with the model's own states
    outputs       the outputs are evaluated beside the derivatives
    update        value and signals of the sampling instant are held in hidden states over the period

Each input is a slot too, of its own name: a law of a signal on its way into the model.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, cached_property, partial
from typing import Any, ClassVar

from ..effects.framework.effect import Applied, Effect
from ..effects.framework.placed import Placed
from ..effects.framework.roles import Signals, by_role, fits, roles
from ..framework.arithmetic import PYTHON, Arithmetic
from ..framework.model import Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import Role

SEPARATOR, AND = "__", "_and_"
EQUATIONS = ("derivatives", "outputs", "update")

Arguments = tuple[Any, Any, Any, Any, Arithmetic]
Note = Callable[[Placed, Any, Signals, Applied], None]


class Composed(Model):
    """
    A model of which some slots hold effects; made by `with_effect`.

    Its class inherits from this one and from the class of the base, so that whatever the base declares is
    declared here as well, and overridden only where an effect changes it.
    """

    base: ClassVar[Model]
    placed: ClassVar[tuple[Placed, ...]]

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        start = self.states.flat(x._asdict())
        seen: dict[str, Any] = {}

        def note(place: Placed, value: Any, s: Signals, applied: Applied) -> None:
            seen.update({f"{place.prefix}_{name}": value for name in place.effect.follows})
            seen.update(place.hold(value, s))

        starts = self._start_of_base(x, u, p, m)
        for _ in self.placed:  # each pass settles at least one more effect of those that follow another
            x = self.states.record(self.states.merged(starts | seen, start))
            for home in self._homes(lambda place: bool(place.effect.follows or place.held)):
                self._call(home, (0.0, x, u, p, m), note)
            if self._input_slots:
                x = self.states.record(self.states.merged(starts | seen, start))
                starts = self._start_of_base(x, u, p, m)
        return starts | seen

    def _start_of_base(self, x: Any, u: Any, p: Any, m: Arithmetic) -> dict[str, Any]:
        slot = partial(self._answer, "initial", (0.0, x, u, p, m), lambda *_: None)
        return dict(self.base.initial(x, self._inputs_after_effects(u, slot), p, m))

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        changes: dict[str, Any] = {}

        def note(place: Placed, value: Any, s: Signals, applied: Applied) -> None:
            changes.update(place.changes(applied, is_sampled=True))
            changes.update(place.hold(value, s))

        new = self._call("update", (t, x, u, p, m), note)
        for home in self._homes(lambda place: any(v.sampled for v in place.effect.states)) - {"update"}:
            self._call(home, (t, x, u, p, m), note)
        return {**new, **changes}

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        changes: dict[str, Any] = {}

        def note(place: Placed, value: Any, s: Signals, applied: Applied) -> None:
            changes.update(place.changes(applied, is_sampled=False))

        der = self._call("derivatives", (t, x, u, p, m), note)
        if "outputs" in self._homes(lambda place: any(not v.sampled for v in place.effect.states)):
            self._call("outputs", (t, x, u, p, m), note)
        for place in self.placed:
            if place.held:
                changes |= place.changes(place.applied_to_held(t, x, p, m), is_sampled=False)
        return {**der, **changes}

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        return self._call("outputs", (t, x, u, p, m), lambda *_: None)

    def faults(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic) -> Sequence[Any]:
        arguments = (t, x, u, p, m)
        slot = partial(self._answer, "faults", arguments, lambda *_: None)
        return self.base.faults(t, x, self._inputs_after_effects(u, slot), p, m)

    def _homes(self, condition: Callable[[Placed], bool]) -> set[str]:
        return {place.home for place in self.placed if condition(place)}

    def _call(self, equation: str, arguments: Arguments, note: Note) -> Values:
        t, x, u, p, m = arguments
        slot = partial(self._answer, equation, arguments, note)
        u = self._inputs_after_effects(u, slot)
        values: Values = getattr(self.base, equation)(t, x, u, p, m, slot=slot)
        return values

    def _answer(
        self, equation: str, arguments: Arguments, note: Note, name: str, value: Any, **signals: Any
    ) -> Any:
        """Pass what is in a slot through its effects; those that the equation owns are noted."""
        t, x, _, p, m = arguments
        for place in self.placed:
            if place.slot.name != name:
                continue
            s = by_role(place.slot, signals)
            applied = place.apply(t, value, s, x, p, m)
            if place.home == equation:
                note(place, value, s, applied)
            value = applied.value
            signals |= {roles(place.slot)[role]: new for role, new in applied.signals.items()}
        return value

    def _inputs_after_effects(self, u: Any, slot: SlotFunction) -> Any:
        """Replace the inputs that are slots of effects by what the base sees of them."""
        return u._replace(**{name: slot(name, getattr(u, name)) for name in self._input_slots})

    @cached_property
    def _input_slots(self) -> list[str]:
        """Inputs that are slots of effects."""
        own = {place.slot.name for place in self.placed}
        return [name for name in self.base.inputs.names if name in own]


def with_effect(
    model: Model,
    slot: str,
    effect: Effect,
    prefix: str | None = None,
    starts: Mapping[str, float] | None = None,
) -> Model:
    """
    Put an effect into a slot, behind those that are there.

    Args:
        model: The model, with or without effects.
        slot: Name of one of its slots.
        effect: The law; it must fit the slot's signals.
        prefix: Begin of the new names, `<slot>_<effect>` if None.
        starts: Start values by the effect's own short names.

    Raises:
        ValueError: If there is no such slot, the effect does not fit, or the prefix is taken.
    """
    base = model.base if isinstance(model, Composed) else model
    before = model.placed if isinstance(model, Composed) else ()
    place = Placed(_slot_of(base, slot), effect, prefix or f"{slot}_{effect.name}", _home(base, slot))
    _check(model, place, before)
    kind = type(base)
    attributes = {
        "__module__": kind.__module__,
        "__doc__": kind.__doc__,
        "base": base,
        "placed": (*before, place),
        "name": model.name + (AND if before else SEPARATOR) + place.prefix,
        "description": f"{model.description} With {effect.name} in {slot}.",
        "variables": (*model.variables, *place.declarations(starts or {})),
    }
    composed: Model = type(f"{kind.__name__}WithEffects", (Composed, kind), attributes)()
    return composed


def _check(model: Model, place: Placed, before: tuple[Placed, ...]) -> None:
    if not fits(place.effect, place.slot):
        raise ValueError(
            f"{model.name}.{place.slot.name}: {place.effect.name} does not fit, got signals "
            f"{[*place.slot.signals]}, expected {[*place.effect.needs]} and a place for "
            f"{' or '.join(sorted(p.value for p in place.effect.places))}"
        )
    if any(place.prefix == other.prefix for other in before):
        raise ValueError(f"{model.name}: prefix is taken, got {place.prefix!r}, expected a new one")


def all_slots(model: Model) -> tuple[Slot, ...]:
    """Slots of the equations, and one for each input that they read."""
    taken = {slot.name for slot in model.slots}
    read = _homes(model.base if isinstance(model, Composed) else model)
    inputs = [v for v in model.group(Role.INPUT) if v.name == v.base and v.name in read.keys() - taken]
    return (*model.slots, *(Slot(v.name, v.unit, v.description) for v in inputs))


class _Watched:
    """A record that notes which fields are read."""

    def __init__(self, record: Any, read: set[str]) -> None:
        self._record, self._read = record, read

    def __getattr__(self, name: str) -> Any:
        self._read.add(name)
        return getattr(self._record, name)


def _slot_of(model: Model, name: str) -> Slot:
    for slot in all_slots(model):
        if slot.name == name:
            return slot
    known = [s.name for s in all_slots(model)]
    raise ValueError(f"{model.name}: no such slot, got {name!r}, expected one of {known}")


def _home(model: Model, slot: str) -> str:
    """Find the equation that owns a slot."""
    try:
        return _homes(model)[slot]
    except KeyError:
        raise ValueError(f"{model.name}.{slot}: the equations do not call this slot") from None


def _noted(called: set[str], name: str, value: Any, **signals: Any) -> Any:
    called.add(name)
    return value


@cache
def _homes(model: Model) -> Mapping[str, str]:
    """Map each slot and input to the first equation that calls or reads it, at the model's start."""
    x, u, p = (
        kind.record([v.start for v in model.group(role)])
        for kind, role in (
            (model.states, Role.STATE),
            (model.inputs, Role.INPUT),
            (model.parameters, Role.PARAMETER),
        )
    )
    homes: dict[str, str] = {}
    for equation in EQUATIONS:
        called: set[str] = set()
        getattr(model, equation)(0.0, x, _Watched(u, called), p, PYTHON, slot=partial(_noted, called))
        homes |= dict.fromkeys(called - set(homes), equation)
    return homes
