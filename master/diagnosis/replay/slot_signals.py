"""What stands in the slots of a part, and their signals, over a replay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fmu_sources.composed.composition import EQUATIONS, all_slots
from fmu_sources.effects.framework.effect import Rms
from fmu_sources.effects.framework.roles import roles
from fmu_sources.framework.array_arithmetic import ARRAYS
from fmu_sources.framework.instance import Instance
from fmu_sources.framework.model import Model
from fmu_sources.framework.variables import Role
from master.diagnosis.case.cut import CutSystem, Values
from master.diagnosis.numerics.arrays import Array
from master.text.signal_name import SignalName

from .replay import Bench
from .replayer import Player

Signals = dict[str, dict[str, Array]]


def slot_signals(
    system: CutSystem, bench: Bench, player: Player, values: Values, only: Sequence[str] | None = None
) -> dict[str, dict[str, Array]]:
    """
    Evaluate the slots of the models of a part along a replay, whatever effects the player has in them.

    Args:
        system: The system.
        bench: What drives the part.
        player: Its FMUs.
        values: Their parameters.
        only: FMUs to look into; all of the part if None.

    Returns:
        `fmu.slot` to role (value, position, velocity, load) to a signal over all samples.
    """
    replayed = bench.record(player, values)
    found: dict[str, dict[str, Array]] = {}
    for fmu in bench.part.fmus if only is None else only:
        model = system.model(fmu)
        if model is None:  # a foreign file has no slots, but what it was driven with is known
            driven = bench.part.inputs[fmu].items()
            found |= {f"{fmu}.{name}": {"value": bench.signal(signal)} for name, (signal, _) in driven}
            continue
        inputs = _inputs(bench, fmu, model, replayed)
        seen = dict(inputs)
        if (model.slots and model.n_continuous) or not model.group(Role.STATE):
            states = {SignalName(k).variable: v for k, v in replayed.items() if k.startswith(f"{fmu}.")}
            called = _by_arrays(model, values[fmu], inputs, states)
        elif model.slots:
            called = _by_steps(model, values[fmu], inputs, bench.period)
        else:
            called = {}
        called |= {name: {"value": seen[name]} for name in inputs}
        slots = {s.name: s for s in all_slots(model)}
        n = len(next(iter(replayed.values())))
        for name, signals in called.items():
            own = {role: signals[signal] for role, signal in roles(slots[name]).items()}
            found[f"{fmu}.{name}"] = {
                role: np.broadcast_to(np.asarray(v, dtype=float), (n,)).copy()
                for role, v in {"value": signals["value"], **own}.items()
            }
    return found


def sizes(signals: Mapping[str, Array], duration: float) -> Rms:
    """Size of what stands in a slot; a signal that is zero counts as one that is small."""

    def rms(role: str) -> float:
        values = signals.get(role)
        return 1.0 if values is None else float(np.sqrt(np.mean(np.square(values)))) or 1.0

    return Rms(
        value=rms("value"),
        position=rms("position"),
        velocity=rms("velocity"),
        load=rms("load"),
        duration=duration,
    )


def _inputs(bench: Bench, fmu: str, model: Model, replayed: Mapping[str, Array]) -> dict[str, Array]:
    n = len(next(iter(replayed.values())))
    found = {}
    for name in model.inputs.names:
        measured = bench.part.inputs[fmu].get(name)
        wire = bench.part.wired[fmu].get(name)
        found[name] = (
            bench.signal(measured[0]) if measured else replayed[wire] if wire else np.zeros(n, dtype=float)
        )
    return found


def _parameters(model: Model, values: Mapping[str, Any]) -> Any:
    return model.parameters.record([values.get(v.name, v.start) for v in model.group(Role.PARAMETER)])


def _by_arrays(
    model: Model, values: Mapping[str, Any], inputs: Mapping[str, Array], states: Mapping[str, Array]
) -> Signals:
    """All instants at once, from the states of a replay."""
    x = model.states.record([states.get(v.name, v.start) for v in model.group(Role.STATE)])
    u = model.inputs.record([inputs[name] for name in model.inputs.names])
    called: Signals = {}

    def note(name: str, value: Any, **signals: Any) -> Any:
        called[name] = {"value": value, **signals}
        return value

    t = np.arange(len(next(iter(inputs.values())))) * 0.0
    for equation in EQUATIONS:
        if equation != "update":
            getattr(model, equation)(t, x, u, _parameters(model, values), ARRAYS, slot=note)
    return called


def _by_steps(model: Model, values: Mapping[str, Any], inputs: Mapping[str, Array], period: float) -> Signals:
    """Step a sampled model, for states that an FMU hides."""
    instance = Instance(model)
    for name, value in values.items():
        if name in instance.index:
            instance[name] = float(value)
    rows: dict[str, list[dict[str, Any]]] = {}

    def note(name: str, value: Any, **signals: Any) -> Any:
        rows.setdefault(name, []).append({"value": value, **signals})
        return value

    n = len(next(iter(inputs.values())))
    for k in range(n):
        for name, column in inputs.items():
            instance[name] = float(column[k])
        if k == 0:
            instance.initialise()
        else:
            instance.step((k - 1) * period, period)
        x = model.states.record(instance.values[instance._x])
        u = model.inputs.record(instance.values[instance._u])
        model.outputs(
            k * period, x, u, model.parameters.record(instance.values[instance._p]), instance.m, slot=note
        )
    return {
        name: {key: np.array([row[key] for row in found]) for key in found[0]} for name, found in rows.items()
    }
