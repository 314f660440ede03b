from __future__ import annotations

import math

import numpy as np
import pytest

from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.integrate import runge_kutta_4
from fmu_sources.motion_simulator.dynamics import accelerations, holding_forces, mechanics
from fmu_sources.motion_simulator.geometry import angle_rates, base_joints, platform_joints
from fmu_sources.motion_simulator.inertia import PointMass, mass_matrix, platform_inertia, platform_mass
from tests.fmu_sources.motion_simulator.hexapod import NEUTRAL, PARAMETERS
from tests.fmu_sources.motion_simulator.mujoco_hexapod import Oracle

REFLECTED = PARAMETERS.J * (2 * math.pi / PARAMETERS.lead) ** 2
SPREAD_POSE = np.array([0.15, 0.15, 0.15, 0.2, 0.2, 0.2])
SPREAD_TWIST = np.array([0.5, 0.5, 0.5, 1.0, 1.0, 1.0])
SPREAD_WRENCH = np.array([500.0, 500.0, 500.0, 200.0, 200.0, 200.0])
FREE_TWIST = (0.05, -0.03, 0.1, 0.05, 0.04, 0.06)


@pytest.mark.parametrize("rotor", [0.0, REFLECTED], ids=["without motors", "with rotors"])
def test_accelerations_are_those_of_mujoco(rotor):
    oracle = Oracle(
        PARAMETERS,
        np.array(base_joints(PARAMETERS, PYTHON)),
        np.array(platform_joints(PARAMETERS, PYTHON)),
        rotor,
    )
    random = np.random.default_rng(6)
    worst = 0.0
    for _ in range(200):
        pose, twist, wrench = (
            s * random.uniform(-1, 1, 6) for s in (SPREAD_POSE, SPREAD_TWIST, SPREAD_WRENCH)
        )
        forces = random.uniform(-2000, 2000, 6)
        at = mechanics(tuple(pose), tuple(twist), PARAMETERS, PYTHON)
        ours = accelerations(at, forces, wrench, rotor, PARAMETERS)
        centre, R = np.add(pose[:3], (0, 0, PARAMETERS.height)), np.column_stack(at.R[:3])
        worst = max(worst, np.abs(ours - oracle.accelerations(centre, R, twist, forces, wrench)).max())

    assert worst <= 1e-9


def test_mass_matrix_is_as_published():
    M_s = whole_mass_matrix(mechanics(NEUTRAL, NEUTRAL, PARAMETERS, PYTHON))

    assert np.diag(M_s) == pytest.approx([550, 550, 556, 111, 111, 177], abs=0.5)


def test_static_leg_force_is_as_published():
    forces = holding_forces(mechanics(NEUTRAL, NEUTRAL, PARAMETERS, PYTHON), NEUTRAL, PARAMETERS)

    assert forces == pytest.approx([1031.0] * 6, abs=0.5)


def test_holding_forces_leave_no_acceleration():
    pose, wrench = (0.05, -0.08, 0.11, 0.2, -0.15, 0.3), (100.0, -200.0, 300.0, 40.0, 50.0, -60.0)
    at = mechanics(pose, NEUTRAL, PARAMETERS, PYTHON)

    forces = holding_forces(at, wrench, PARAMETERS)
    assert accelerations(at, forces, wrench, REFLECTED, PARAMETERS) == pytest.approx([0.0] * 6, abs=1e-11)


@pytest.mark.long
def test_energy_of_ten_seconds_of_free_motion_is_kept_with_order_4():
    coarse, fine = (drift(NEUTRAL, FREE_TWIST, h, stiffness=0.0) for h in (4e-3, 2e-3))

    assert fine <= 1e-6
    assert math.log2(coarse / fine) == pytest.approx(4.0, abs=0.3)


@pytest.mark.long
def test_energy_of_ten_seconds_on_elastic_legs_is_kept():
    pose, twist = (0.05, 0.02, 0.0, 0.05, 0.05, 0.05), tuple(5 * v for v in FREE_TWIST)
    coarse, fine = (drift(pose, twist, h, stiffness=2e5) for h in (1e-3, 0.5e-3))

    assert fine <= 1e-6
    assert math.log2(coarse / fine) >= 4.0


def drift(pose, twist, h, stiffness):
    """Largest change of the energy in 10 s relative to what it exchanges; legs without motors, gravity on."""

    def h_times_derivatives(place, x):
        at = mechanics(x[:6], x[6:], PARAMETERS, PYTHON)
        forces = [-stiffness * (leg.l - 1.5) for leg in at.legs]
        nu = accelerations(at, forces, NEUTRAL, 0.0, PARAMETERS)
        return [h * d for d in (*x[6:9], *angle_rates(at.R, at.omega), *nu)]

    x = [*pose, *twist]
    energies = [energy(x, stiffness)]
    for _ in range(100):
        x = runge_kutta_4(h_times_derivatives, round(0.1 / h), x)
        energies.append(energy(x, stiffness))
    kinetic, total = np.array(energies)[:, 0], np.sum(energies, axis=1)
    return np.abs(total - total[0]).max() / np.ptp(kinetic)


def energy(x, stiffness):
    """Kinetic energy, and potential energy of weight and springs [J]."""
    at, p = mechanics(x[:6], x[6:], PARAMETERS, PYTHON), PARAMETERS
    nu = np.array(x[6:])
    platform = p.m_p * (p.height + x[2] + p.c_p * at.R.z[2])
    legs = sum((p.m_1 * p.c_1 + p.m_2 * (leg.l - p.c_2)) * leg.n[2] for leg in at.legs)
    springs = sum(0.5 * stiffness * (leg.l - 1.5) ** 2 for leg in at.legs)
    return 0.5 * nu @ whole_mass_matrix(at) @ nu, p.g * (platform + legs) + springs


def whole_mass_matrix(at):
    pairs = list(zip(at.legs, at.motions, strict=True))
    masses = [platform_mass(at.R, PARAMETERS), *(PointMass(motion.mu, leg.r) for leg, motion in pairs)]
    kappa = [PARAMETERS.m_2 - motion.mu for motion in at.motions]
    M_s = np.zeros((6, 6))
    for i, row in enumerate(mass_matrix(at.legs, masses, platform_inertia(at.R, PARAMETERS), kappa)):
        M_s[i, : i + 1] = M_s[: i + 1, i] = row
    return M_s
