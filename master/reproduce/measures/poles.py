"""
Poles and zeros of the loop, from the FMUs as they are stepped, and of the real docking alone.

The zeros are those of the path from the drag velocity v to the motion of the spacecraft, in the loop with
compensation and in the real docking.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig

from master.analysis.closed_loop.linearise import Linearisation
from master.analysis.closed_loop.tick_matrix import LinearSystem
from master.analysis.measures.poles import Pole, dominant, growth_rate, nearest, poles
from master.experiment.experiment import Experiment
from master.fmi.units import conversion
from master.system.graph import Wire

Complexes = NDArray[np.complex128]

_DRAG = ("contact.v", "ideal.v")
_SPREAD = 2500.0
_SLOWEST_DELAY = 0.5  # a dead time has poles at z = 0, and a motor's current decays faster


@dataclass(frozen=True)
class Plane:
    """Poles and zeros in the s plane [1/s], without those at rest."""

    poles: Complexes
    zeros: Complexes


@dataclass(frozen=True)
class Judged:
    """Dominant pole, the nearest one of the real docking, and the growth of the fastest pole [1/s]."""

    dominant: Pole | None
    reference: Pole | None
    fastest: float


_NOISE = ("seed", "sigma")
_KEPT = 64


@dataclass(frozen=True)
class _Asked:
    """An experiment, equal to every other one with the same linearisation, by which answers are kept."""

    key: Hashable
    experiment: Experiment = field(compare=False)


def _asked(experiment: Experiment) -> _Asked:
    """Name all that a linearisation depends on; noise has no part in it."""
    system = experiment.system
    schedule = experiment.schedule
    instances = tuple(
        (
            name,
            instance.description.path,
            instance.every,
            frozenset((k, repr(v)) for k, v in instance.start.items() if k not in _NOISE),
        )
        for name, instance in system.instances.items()
    )
    wires = tuple(
        (w.source.name, w.target.name, w.delay, w.extrapolation, w.conversion) for w in system.wires
    )
    order = (schedule.groups, frozenset(schedule.every.items()))
    return _Asked((instances, wires, order, experiment.grid, experiment.compare), experiment)


def judged(experiment: Experiment) -> Judged:
    """Judge a system by its poles."""
    return _judged(_asked(experiment))


@lru_cache(maxsize=_KEPT)
def _judged(asked: _Asked) -> Judged:
    experiment = asked.experiment
    coupled = Linearisation(experiment).coupled()
    compare = experiment.compare
    best = dominant(poles(coupled, None if compare is None else compare.signal))
    reference = None
    if best is not None and compare is not None and compare.reference is not None:
        name = compare.reference.instance
        period = coupled.step_size * coupled.schedule.every[name]
        reference = nearest(coupled.parts[name].system, period, best)
    return Judged(best, reference, growth_rate(coupled))


def driven(experiment: Experiment) -> Experiment:
    """Connect the drag velocities, so that the analysis sees inputs; they start at 0."""
    system = experiment.system
    source = system.port("spacecraft.v_des")
    wires = [
        Wire(source, port, 0, found)
        for port in map(system.port, _DRAG)
        if (found := conversion(source.variable.unit, port.variable.unit)) is not None
    ]
    return replace(experiment, system=replace(system, wires=(*system.wires, *wires)))


def planes(experiment: Experiment) -> tuple[Plane, Plane]:
    """Return poles and zeros of the real docking, and of the loop."""
    coupled = Linearisation(driven(experiment)).coupled()
    return _ideal(coupled), _loop(coupled)


def _ideal(coupled: LinearSystem) -> Plane:
    part = coupled.parts["ideal"]
    system = part.system
    row = part.outputs.index("ideal.s")
    column = part.inputs.index("ideal.v")
    B, C, D = system.B[:, [column]], system.C[[row]], system.D[[row]][:, [column]]
    return _plane(np.linalg.eigvals(system.A), _zeros(system.A, B, C, D), coupled.step_size)


def without_ideal(coupled: LinearSystem) -> LinearSystem:
    """Leave the real docking out, which is no part of the loop."""
    system, schedule = coupled.system, coupled.schedule
    groups = tuple(g for g in schedule.groups if g.members != ("ideal",))
    instances = {name: i for name, i in system.instances.items() if name != "ideal"}
    wires = tuple(w for w in system.wires if w.target.instance != "ideal")
    return replace(
        coupled,
        system=replace(system, instances=instances, wires=wires),
        schedule=replace(schedule, groups=groups, every={n: schedule.every[n] for n in instances}),
        parts={name: part for name, part in coupled.parts.items() if name != "ideal"},
    )


def _loop(coupled: LinearSystem) -> Plane:
    coupled = without_ideal(coupled)
    wires = {w.target.name: w for w in coupled.wires}
    loop = coupled.opened(wires["contact.v"], cut=True)
    C = coupled.row("spacecraft.s_des")[None]
    found = _zeros(loop.M, loop.N, C, np.zeros((1, 1)))
    return _plane(np.linalg.eigvals(loop.M), found, coupled.step_size)


def _zeros(A: Any, B: Any, C: Any, D: Any) -> Complexes:
    n = len(A)
    unit = np.zeros((n + 1, n + 1))
    unit[:n, :n] = np.eye(n)
    found: Any = eig(np.block([[A, B], [C, D]]), unit, right=False)
    return np.asarray(found[np.isfinite(found)])


def _plane(poles_z: Any, zeros_z: Any, step: float) -> Plane:
    return Plane(_continuous(poles_z, step), _continuous(zeros_z, step))


def _continuous(z: Any, step: float) -> Complexes:
    inside = z[(np.abs(z) > 1e-3) & (np.abs(z) < 1e2) & (np.abs(z - 1.0) > 1e-6)]
    s = np.log(inside.astype(complex)) / step
    return np.asarray(s[np.abs(s) < _SPREAD])


def cancellation(experiment: Experiment) -> float:
    """
    Largest distance of a pole that stems from the motion simulator to a zero, over |pole|^2 T/2.

    That is the distance by which a backward difference, (1 - exp(-s T))/T = s - s^2 T/2 + ..., misses s.
    """
    return _cancellation(_asked(experiment))


@lru_cache(maxsize=_KEPT)
def _cancellation(asked: _Asked) -> float:
    coupled = Linearisation(driven(asked.experiment)).coupled()
    alone = np.linalg.eigvals(coupled.parts["motion_simulator"].system.A)
    s = _continuous(alone[np.abs(alone) > _SLOWEST_DELAY], coupled.step_size)
    loop = _loop(coupled)
    own = loop.poles[np.argmin(np.abs(s[:, None] - loop.poles[None, :]), axis=1)]
    distances = np.abs(own[:, None] - loop.zeros[None, :])
    return float(np.max(distances.min(axis=1) / (0.5 * coupled.step_size * np.abs(own) ** 2)))


def cancelled(plane: Plane, tolerance: float = 1e-2) -> tuple[Sequence[bool], Sequence[bool]]:
    """Say which poles and which zeros lie on one another, within a share of their modulus."""
    near = np.abs(plane.poles[:, None] - plane.zeros[None, :]) < tolerance * np.abs(plane.poles)[:, None]
    return [bool(row.any()) for row in near], [bool(column.any()) for column in near.T]
