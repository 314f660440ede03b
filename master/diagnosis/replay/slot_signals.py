"""What is in the slots of a part, and their signals, over a replay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fmu_sources.composed.composition import EQUATIONS, all_slots
from fmu_sources.effects.framework.effect import Rms
from fmu_sources.effects.framework.roles import roles
from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.array_arithmetic import ARRAYS
from fmu_sources.framework.instance import RELATIVE_STEP_TOLERANCE, Instance
from fmu_sources.framework.model import Model
from fmu_sources.framework.variables import Role
from master.diagnosis.case.cut import CutSystem, Values
from master.diagnosis.numerics.arrays import Array
from master.fmi.units import Conversion
from master.text.signal_name import SignalName

from .replay_bench import ReplayBench, Segment
from .replayer import Player

Signals = dict[str, dict[str, Array]]
"""Slot `fmu.slot` to role (value, position, velocity, load) to a signal, shape (samples,)."""

Calls = dict[str, dict[str, Any]]
"""Slot to what an equation hands to it: `value`, and its signals by their own names; arrays or numbers."""


def slot_signals(
    system: CutSystem,
    bench: ReplayBench,
    player: Player,
    values: Values,
    only: Sequence[str] | None = None,
) -> Signals:
    """
    Evaluate the slots of the models of a part along a replay, whatever effects the player has in them.

    Args:
        system: The system.
        bench: What drives the part.
        player: Its FMUs.
        values: Their parameters.
        only: FMUs to look into; all of the part if None.
    """
    replayed = bench.record(player, values)
    signals: Signals = {}
    for fmu in bench.part.fmus if only is None else only:
        model = system.model(fmu)
        if model is None:  # a foreign file has no slots, but what it was driven with is known
            driven = bench.part.inputs[fmu].items()
            signals |= {f"{fmu}.{name}": {"value": bench.signal(m.signal)} for name, m in driven}
            continue
        inputs = _inputs(bench, fmu, model, replayed, values[fmu])
        calls: Calls = {}
        if (model.slots and model.n_continuous) or not model.group(Role.STATE):
            states = {SignalName(k).variable: v for k, v in replayed.items() if k.startswith(f"{fmu}.")}
            calls = _by_arrays(model, _over_samples(bench, values, fmu), bench.times, inputs, states)
        elif model.slots:
            calls = _by_steps(model, values, fmu, bench, inputs)
        calls |= {name: {"value": column} for name, column in inputs.items()}
        signals |= _by_role(fmu, model, calls, len(bench.times))
    return signals


def signal_rms(signals: Mapping[str, Array], duration: float) -> Rms:
    """Size of what is in a slot; a signal that is zero counts as 1."""

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


def _by_role(fmu: str, model: Model, calls: Calls, n: int) -> Signals:
    """Signals of the slots by role instead of their own names, each over all n samples."""
    slots = {s.name: s for s in all_slots(model)}
    signals: Signals = {}
    for name, given in calls.items():
        if name not in slots:  # an element of an array that is an input
            continue
        by_role = {"value": given["value"]}
        by_role |= {role: given[signal] for role, signal in roles(slots[name]).items()}
        signals[f"{fmu}.{name}"] = {
            role: np.broadcast_to(np.asarray(v, dtype=float), (n,)).copy() for role, v in by_role.items()
        }
    return signals


def _inputs(
    bench: ReplayBench, fmu: str, model: Model, replayed: Mapping[str, Array], values: Mapping[str, Any]
) -> dict[str, Array]:
    """Each input of a model over all samples: as measured, as wired, or the value it keeps."""
    inputs = {}
    starts = {v.name: v.start for v in model.group(Role.INPUT)}
    for name in model.inputs.names:
        measured = bench.part.inputs[fmu].get(name)
        wire = bench.part.wired[fmu].get(name)
        if measured:
            inputs[name] = bench.signal(measured.signal)
        elif wire:
            carried = bench.part.conversions.get(f"{fmu}.{name}", Conversion())
            inputs[name] = np.array([carried.of(v) for v in replayed[wire].tolist()])
        else:
            inputs[name] = np.full(len(bench.times), float(values.get(name, starts[name])))
    return inputs


def _by_arrays(
    model: Model,
    values: Mapping[str, Any],
    t: Array,
    inputs: Mapping[str, Array],
    states: Mapping[str, Array],
) -> Calls:
    """All instants t [s] at once, from the states of a replay."""
    x = model.states.record([states.get(v.name, v.start) for v in model.group(Role.STATE)])
    u = model.inputs.record([inputs[name] for name in model.inputs.names])
    p = model.parameters.record([values.get(v.name, v.start) for v in model.group(Role.PARAMETER)])
    calls: Calls = {}

    def note(name: str, value: Any, **signals: Any) -> Any:
        calls[name] = {"value": value, **signals}
        return value

    for equation in EQUATIONS:
        if equation != "update":
            getattr(model, equation)(t, x, u, p, ARRAYS, slot=note)
    return calls


def _over_samples(bench: ReplayBench, values: Values, fmu: str) -> Mapping[str, Any]:
    """Values of an FMU; what differs from recording to recording is an array over all samples."""
    own = {name: bench.values_in(values, name)[fmu] for name in bench.recordings}
    first = next(iter(own.values()))
    over: dict[str, Any] = dict(first)
    for name in {key for given in own.values() for key in given}:
        if any(given.get(name) != first.get(name) for given in own.values()):
            parts = [np.full(len(r), float(own[key][name])) for key, r in bench.recordings.items()]
            over[name] = np.concatenate(parts)
    return over


def _by_steps(
    model: Model, values: Values, fmu: str, bench: ReplayBench, inputs: Mapping[str, Array]
) -> Calls:
    """Step a sampled model, for states that an FMU hides; each segment starts as its replay does."""
    states = [
        _stepped(
            model,
            bench.values_in(values, segment.recording)[fmu],
            bench.period,
            segment,
            inputs,
            bench.first_sample(segment.recording),
        )
        for segment in bench.segments
    ]
    x = model.states.record(list(np.concatenate(states).T))
    u = model.inputs.record([inputs[name] for name in model.inputs.names])
    over = _over_samples(bench, values, fmu)
    p = model.parameters.record([over.get(v.name, v.start) for v in model.group(Role.PARAMETER)])
    calls: Calls = {}

    def note(name: str, value: Any, **signals: Any) -> Any:
        calls[name] = {"value": value, **signals}
        return value

    model.outputs(bench.times, x, u, p, ARRAYS, slot=note)
    return calls


def _stepped(
    model: Model,
    values: Mapping[str, Any],
    period: float,
    segment: Segment,
    inputs: Mapping[str, Array],
    first: int,
) -> Array:
    """States of a sampled model at each sample of a segment, shape (samples of it, states)."""
    instance = Instance(model)
    for name, value in values.items():
        if name in instance.index:
            instance[name] = float(value)
    rows = slice(first + segment.begin, first + segment.end)
    columns = np.column_stack([inputs[name][rows] for name in model.inputs.names]).tolist()
    names = [v.name for v in model.group(Role.STATE)]
    own_period = period if model.sample_time is None else instance[model.sample_time]
    is_plain = abs(own_period - period) <= RELATIVE_STEP_TOLERANCE * period and not any(
        v.restarts for v in model.all_variables
    )
    states: list[list[Any]] = []
    p: Any = None
    for k, row in enumerate(columns):
        t = (segment.begin + k) * period
        if k == 0 or not is_plain:
            for name, value in zip(model.inputs.names, row, strict=True):
                instance[name] = value
            if k == 0:
                instance.initialise(t)
                p = model.parameters.record([instance[v.name] for v in model.group(Role.PARAMETER)])
            else:
                instance.step(t - period, period)
            now = [instance[name] for name in names]
        else:  # one sample a row: no need to look anything up by its name
            x = model.states.record(states[-1])
            new = model.update(t - period, x, model.inputs.record(row), p, PYTHON)
            now = model.states.merged(new, states[-1])
        states.append(now)
    return np.array(states, dtype=np.float64)
