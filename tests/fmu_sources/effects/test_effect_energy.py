"""No friction law feeds energy, whatever the motion."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from fmu_sources.effects.catalogue import effect
from fmu_sources.effects.framework.roles import Signals
from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.integrate import runge_kutta_4

STATELESS = ["coulomb", "stribeck", "asymmetric_friction", "load_friction", "quadratic_damping"]
WITH_MEMORY = ["presliding", "dahl", "bouc_wen"]


@pytest.mark.parametrize("name", STATELESS)
@pytest.mark.parametrize("velocity", [-1.0, -0.1, -1e-4, 1e-4, 0.1, 1.0])
def test_power_is_taken_at_every_velocity(name, velocity, values_of):
    found = effect(name)
    s = Signals(position=0.01, velocity=velocity, load=80.0)

    force = found.law(0.0, 0.0, s, None, values_of(found), PYTHON).value

    assert force * velocity > 0.0


@pytest.mark.parametrize("name", WITH_MEMORY)
def test_closed_cycles_take_energy(name, values_of):
    found, p, h = effect(name), values_of(effect(name)), 2e-4
    (only,) = (v.name for v in found.states)
    x, work = [0.0], []

    def law(t, z):
        angle = 2.0 * math.pi * t
        s = Signals(position=0.01 * math.sin(angle), velocity=0.02 * math.pi * math.cos(angle))
        return found.law(t, 0.0, s, SimpleNamespace(**{only: z}), p, PYTHON), s

    for k in range(5000 * 3):
        applied, s = law(k * h, x[0])
        work.append(applied.value * s.velocity * h)
        x = runge_kutta_4(lambda place, z, k=k: [h * law((k + place) * h, z[0])[0].changes[only]], 1, x)

    cycles = [sum(work[i : i + 5000]) for i in (5000, 10000)]
    assert cycles[0] > 0.0
    assert cycles[0] == pytest.approx(cycles[1], rel=1e-3)
