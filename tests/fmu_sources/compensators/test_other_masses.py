"""Methods where the mass feels more than f_comp, and the contact is a specimen: exact ramps and parabolas."""

from __future__ import annotations

import pytest

from fmu_sources.composed.registry import load
from fmu_sources.framework.instance import Instance

T = 1e-3
K_P, W_V, Z, DEAD_TIME = 30.0, 100.0, 0.8, 0.002
TAU = DEAD_TIME + 0.5 * T
D_1 = 1.0 / K_P + TAU
D_2 = 2.0 * Z / (W_V * K_P) + TAU / K_P + TAU**2 / 2.0
K, C = 2e5, 300.0
DIRECT = {"contact": 2, "k_m": K, "c_m": C, "latency_tolerance": 0.0, "damping_tolerance": 0.0}


def driven(name, motion, f_mea, s_act=None, a_des=0.0, n=40, **values):
    """Let s_des be motion(t), the others constants or functions of t; return f_comp and s_cmd in the end."""
    instance = Instance(load(name))
    believed = {"K_p": K_P, "w_v": W_V, "z": Z, "dead_time": DEAD_TIME, "T_f_hat": 0.0, "m_s": 500.0}
    for key, value in {**believed, **values}.items():
        instance[key] = value
    for k in range(n):
        t = k * T
        instance["s_des"] = motion(t)
        instance["s_act"] = (s_act or motion)(t)
        instance["f_mea"] = f_mea(t)
        instance["a_des"] = a_des
        if k == 0:
            instance.initialise()
        instance.step(t, T)
    return instance["f_comp"], instance["s_cmd"]


@pytest.mark.parametrize("name", ["inverse3", "ats", "amb"])
def test_a_given_acceleration_makes_the_command_and_the_force_does_not(name):
    """On s = 2 t^2: s_cmd = s + d_1 v + d_2 a; `ats` has learned a little in three periods."""
    given = {"uses_a_des": True, "a_des": 4.0, **({"rate": 0.0} if name == "amb" else {})}
    t = 2 * T
    commands = [driven(name, lambda t: 2.0 * t * t, lambda t, f=f: f, n=3, **given)[1] for f in (0.0, 1000.0)]

    assert commands[0] == commands[1]
    assert commands[0] == pytest.approx(
        2.0 * t * t + D_1 * 4.0 * t + D_2 * 4.0, rel=1e-4 if name == "ats" else 1e-9
    )


def test_without_it_the_force_makes_the_command():
    commands = [driven("inverse3", lambda t: 0.0, lambda t, f=f: f, n=3)[1] for f in (0.0, 1000.0)]

    assert commands[1] - commands[0] == pytest.approx(D_2 * 1000.0 / 500.0 + 0.5 * T * D_1 * 2.0, rel=1e-9)


def test_a_direct_contact_is_a_spring_and_a_damper_on_what_is_not_reached():
    """The rig is at 0.9 of the ramp with the force of spring and damper there; f_comp is that of the ramp."""
    v = 0.2
    force, _ = driven(
        "robust",
        lambda t: v * t,
        lambda t: -K * 0.9 * v * t - (C * 0.9 * v if t > 0.0 else 0.0),
        s_act=lambda t: 0.9 * v * t,
        uses_a_des=True,
        **DIRECT,
    )

    assert force == pytest.approx(-K * v * 39 * T - C * v, rel=1e-9)


def test_the_delay_of_the_force_is_made_up_for_by_the_motion_to_come():
    v, delay = 0.2, 0.004
    plain, ahead = (
        driven("robust", lambda t: v * t, lambda t: -K * v * t, uses_a_des=True, force_delay=d, **spring())[0]
        for d in (0.0, delay)
    )

    assert ahead - plain == pytest.approx(-K * delay * v, rel=1e-9)


def spring():
    return {**DIRECT, "c_m": 0.0}


def test_an_advance_moves_the_command_and_not_the_force():
    v, advance = 0.2, 0.003
    known = {"plant_gain_tolerance": 0.0, "plant_lag_tolerance": 0.0, "uses_a_des": True, **spring()}
    (f_0, s_0), (f_1, s_1) = (
        driven("robust", lambda t: v * t, lambda t: -K * v * t, advance=d, **known) for d in (0.0, advance)
    )

    assert s_1 - s_0 == pytest.approx(advance * v, rel=1e-9)
    assert s_0 == pytest.approx(v * 39 * T + D_1 * v, rel=1e-9)
    assert f_1 == f_0


def test_noise_of_the_encoder_that_is_said_keeps_the_plant_as_believed():
    """A rig 10 % too large: the command shrinks, but hardly where the readings have 1 m of noise."""
    gains = []
    for noise in (1e-6, 1.0):
        _, s_cmd = driven(
            "robust",
            lambda t: 0.2 * t,
            lambda t: -K * 0.2 * t,
            s_act=lambda t: 0.22 * t,
            n=400,
            encoder_noise=noise,
            uses_a_des=True,
            **spring(),
        )
        gains.append(s_cmd / (0.2 * 399 * T + 0.2 * D_1))

    assert abs(gains[1] - 1.0) < 2e-3
    assert abs(gains[0] - 1.0) > 0.02


def test_below_its_level_amb_learns_nothing():
    wave = [1e-5 * (-1) ** (k // 20) for k in range(400)]
    learned = []
    for level in (1e-6, 1e-2):
        instance = Instance(load("amb"))
        instance["level"] = level
        for k, s in enumerate(wave):
            instance["s_des"], instance["s_act"] = s, 0.5 * s
            if k == 0:
                instance.initialise()
            instance.step(k * T, T)
        learned.append(max(abs(instance[f"theta[{i}]"]) for i in (1, 2, 3, 4)))

    assert learned[1] < 1e-4 < 1e-2 < learned[0]
