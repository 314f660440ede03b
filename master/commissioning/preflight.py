"""
Pre-flight: how stable a system is, as it is stepped, for every plant of a box.

Each plant is the matrix of one tick with adaptation frozen: what FMUs declare not to be linear stays as they
believe it. The damping is the least of all poles in which an FMU of a loop participates. How much later and
how much earlier the measured force may come is found by root search on the opened loop (`measures.margins`).
Closed form next to it, for one lightly damped mode at w: a delay tau changes zeta by -w tau/2.
Limits   Adaptation, saturation and what FMUs do at their limits are not in it: a guard is.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from master.analysis.closed_loop.linearise import Assumption, Linearisation, without_reference
from master.analysis.closed_loop.tick_matrix import LinearSystem
from master.analysis.measures.margins import delay_margin
from master.analysis.measures.poles import Pole, poles
from master.errors import ConfigError, Problem, nearest
from master.experiment.experiment import Experiment
from master.stepping.simulate import SlaveFactory, load
from master.system.graph import Wire

from .box import SENSOR, Box, instance_of, own_values

LARGEST_MISFIT = 1e-3
LARGEST_CURVATURE = 1e-2
"""Relative errors of an FMU's linear system beyond which nothing is said of its loops."""
NEUTRAL = 1e-7
"""Distance of a pole from z = 1 within which it neither grows nor decays."""


@dataclass(frozen=True)
class Plant:
    """
    One plant of a box: its factors, and the pole of its loops that is damped least.

    `later` and `earlier` [s]: how much later or earlier than it does the measured force may come before a
    pole grows; None: any, or `zeta` is not above 0 already.
    """

    factors: Mapping[str, float]
    zeta: float
    frequency: float
    later: float | None
    earlier: float | None

    @property
    def stable(self) -> bool:
        """Whether no pole grows."""
        return self.zeta > 0.0

    def as_dict(self) -> dict[str, Any]:
        """Fields for JSON."""
        return {
            "factors": dict(self.factors),
            "zeta": self.zeta,
            "frequency": self.frequency,
            "later": self.later,
            "earlier": self.earlier,
        }


@dataclass(frozen=True)
class Preflight:
    """What is found over a box, for one method of compensation."""

    method: str
    force_path: str
    nominal: Plant
    plants: Sequence[Plant]
    assumptions: tuple[Assumption, ...]
    notes: tuple[str, ...] = ()

    @property
    def worst(self) -> Plant:
        """The plant with the least damping."""
        return min((self.nominal, *self.plants), key=lambda plant: plant.zeta)

    @property
    def stable(self) -> bool:
        """Whether every plant is known to be stable."""
        return self.worst.stable and not self.notes

    @property
    def latency(self) -> float | None:
        """How far off [s] the delay of the force path may be for every plant; None: by any, or unstable."""
        if not self.stable:
            return None
        bounds = [d for p in (self.nominal, *self.plants) for d in (p.later, p.earlier) if d is not None]
        return min(bounds, default=None)

    @property
    def closed_form(self) -> float:
        """2 zeta/w [s] of the worst plant; below 0: by how much the force would have to come earlier."""
        return self.worst.zeta / (np.pi * self.worst.frequency) if self.worst.frequency > 0.0 else 0.0

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        if self.notes:
            return f"not judged: {'; '.join(self.notes)}"
        n_bad = sum(not plant.stable for plant in self.plants)
        if n_bad:
            return (
                f"not stable for every plant in this box: {n_bad} of {len(self.plants)} grow, the worst with "
                f"{factors_text(self.worst.factors)}"
            )
        if not self.stable:
            return "not stable as it is configured"
        if self.latency is None:
            return "stable for every plant in this box, whatever the delay of the force path"
        return (
            f"stable for every plant in this box if the force path is known to +-{1e3 * self.latency:.2f} ms"
        )

    def as_dict(self) -> dict[str, Any]:
        """Fields for JSON."""
        return {
            "method": self.method,
            "stable": self.stable,
            "sentence": self.sentence,
            "force_path": self.force_path,
            "latency": self.latency,
            "latency_closed_form": self.closed_form,
            "nominal": self.nominal.as_dict(),
            "worst": self.worst.as_dict(),
            "plants": [plant.as_dict() for plant in self.plants],
            "assumptions": [vars(a) for a in self.assumptions],
            "notes": list(self.notes),
        }


def factors_text(factors: Mapping[str, float]) -> str:
    """Say a plant's factors."""
    return ", ".join(f"{name} x{factor:.4g}" for name, factor in factors.items()) or "the nominal plant"


def preflight(
    experiment: Experiment,
    box: Box,
    method: str,
    done: Callable[[int], None] = lambda _: None,
    factory: SlaveFactory = load,
) -> Preflight:
    """
    Judge a system for every plant of a box; `done` is told how many are.

    Raises:
        ConfigError: If the box is not about this system, or the system has no loop.
        FmuError: If an FMU fails, or cannot save its state.
    """
    own = own_values(box, experiment.system)
    linearisation = Linearisation(without_reference(experiment), factory)
    coupled = linearisation.coupled()
    looped = in_loops(coupled)
    if not looped:
        raise ConfigError([Problem("no FMU is in a loop", where="connections", expected="a closed loop")])
    if coupled.period != 1:
        raise ConfigError(
            [Problem("FMUs of several rates", where="fmus", expected="every FMU to step each tick")]
        )
    wire = force_path(experiment, coupled, box)
    axes = [[(name, float(f)) for f in unknown.values(box.points)] for name, unknown in box.box.items()]
    plants = []
    for corner in itertools.product(*axes):
        changes: dict[str, float] = {}
        for name, factor in corner:
            changes |= box.box[name].changes(factor, own)
        plants.append(_judged(linearisation.coupled(changes), wire, looped, dict(corner)))
        done(1)
    nominal = _judged(coupled, wire, looped, {})
    notes = tuple(_objections(coupled, looped))
    return Preflight(method, wire.target.name, nominal, plants, linearisation.assumptions, notes)


def _objections(coupled: LinearSystem, looped: set[str]) -> Iterator[str]:
    """Say which FMUs of the loops a linear system does not repeat well enough to be judged by it."""
    for name in looped:
        system = coupled.parts[name].system
        if system.misfit > LARGEST_MISFIT:
            yield f"the answers of {name} alone are repeated to {system.misfit:.1e} only"
        if system.curvature > LARGEST_CURVATURE:
            yield f"{name} is not linear, its answers bend by {system.curvature:.1e}"


def in_loops(coupled: LinearSystem) -> set[str]:
    """Return the FMUs that a path over the connections leads from back to."""
    names = list(coupled.parts)
    reached = np.zeros((len(names), len(names)), dtype=bool)
    for wire in coupled.wires:
        reached[names.index(wire.source.instance), names.index(wire.target.instance)] = True
    for _ in names:
        reached |= reached @ reached
    return {name for i, name in enumerate(names) if reached[i, i]}


def force_path(experiment: Experiment, coupled: LinearSystem, box: Box) -> Wire:
    """
    Return the connection on which the force is late: into the force sensor, or as the box says.

    Raises:
        ConfigError: If there is none, or the box names what is no connected input.
    """
    wires = {wire.target.name: wire for wire in coupled.wires}
    if box.force_path is not None:
        if box.force_path not in wires:
            got = repr(str(box.force_path))
            expected = nearest(str(box.force_path), wires)
            problem = Problem("no such connected input", where="force_path", got=got, expected=expected)
            raise ConfigError([problem])
        return wires[box.force_path]
    sensor = instance_of(experiment.config, SENSOR)
    found = [wire for wire in coupled.wires if wire.target.instance == sensor]
    if not found:
        expected = "force_path in the box: the input that gets the force"
        raise ConfigError([Problem(f"no connected FMU of {SENSOR}", where="fmus", expected=expected)])
    return found[0]


def _judged(coupled: LinearSystem, wire: Wire, looped: set[str], factors: Mapping[str, float]) -> Plant:
    own = [pole for pole in poles(coupled) if _is_of(pole, looped) and abs(pole.z - 1.0) > NEUTRAL]
    least = min(own, key=lambda pole: pole.zeta)
    if least.zeta <= 0.0:
        return Plant(factors, least.zeta, least.frequency, None, None)
    found = delay_margin(coupled, wire)
    return Plant(factors, least.zeta, least.frequency, found.later, found.earlier)


def _is_of(pole: Pole, looped: set[str]) -> bool:
    """Whether an FMU of a loop, or a value on its way to one, participates."""
    return any(name.partition(".")[0] in looped for name, _ in pole.parts)
