"""`robust` on signals whose contact force and plant are computed by SciPy."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy import signal

from fmu_sources.composed.registry import load
from fmu_sources.framework.instance import Instance

T = 1e-3
W = 2.0 * math.pi * 0.87
CONTACT = {"m_e": 100.0, "k_m": 139_200.0, "c_m": 136.1, "k_p": 37_760.0, "c_p": 97.3}
STIFFNESS = CONTACT["k_m"] * CONTACT["k_p"] / (CONTACT["k_m"] + CONTACT["k_p"])
LOSS = 2.2356e-3
"""t_s of this contact [s], by hand: 136.1/139200 + 97.3/37760 - 233.4/176960."""
AMPLITUDE = 0.005


@dataclass(frozen=True)
class Heard:
    """What the compensator said, and what it should have said [N, s]."""

    force: np.ndarray
    ideal: np.ndarray
    adopted: float
    latency: float
    kappa: float

    def error(self, first: float) -> float:
        """Largest error after `first` [s], as a share of the amplitude of the force."""
        k = round(first / T)
        return float(np.abs(self.force - self.ideal)[k:].max() / (STIFFNESS * AMPLITUDE))


def restoring_force(s, contact, T_f):
    """-G s/(1 + T_f s) for an s that is linear between the samples, steady at the start."""
    k_m, c_m, k_p, c_p = (contact[name] for name in ("k_m", "c_m", "k_p", "c_p"))
    numerator = np.polymul([c_m, k_m], [c_p, k_p])
    denominator = np.polymul([contact["m_e"], c_m + c_p, k_m + k_p], [T_f, 1.0] if T_f else [1.0])
    system = signal.tf2ss(numerator, denominator)
    steady = -np.linalg.solve(system[0], system[1][:, 0]) * s[0]
    return -signal.lsim(system, s, np.arange(len(s)) * T, steady)[1]


def heard(seconds=4.0, late=0.04, T_f=0.01, scale=None, sigma=0.0, **values):
    """Drive `robust` with a decaying oscillation that the motion simulator reproduces late."""
    true = {name: value * (scale or {}).get(name, 1.0) for name, value in CONTACT.items()}
    t = np.arange(round(seconds / T)) * T

    def motion(at):
        return np.where(at < 0.0, AMPLITUDE, AMPLITUDE * np.exp(-0.03 * at) * np.cos(W * np.maximum(at, 0.0)))

    s_des, s_act = motion(t), motion(t - late)
    noise = sigma * np.random.default_rng(1).normal(size=len(t))
    f_mea = restoring_force(s_act, true, T_f) + noise
    instance = Instance(load("robust"))
    for name, value in {**CONTACT, "m_s": 1000.0, **values}.items():
        instance[name] = value
    instance["s_des"], instance["s_act"], instance["f_mea"] = s_des[0], s_act[0], f_mea[0]
    instance.initialise()
    force = []
    for k in range(len(t)):
        instance["s_des"], instance["s_act"], instance["f_mea"] = s_des[k], s_act[k], f_mea[k]
        instance.step(k * T, T)
        force.append(instance["f_comp"])
    ideal = restoring_force(s_des, true, 0.0)
    return Heard(np.array(force), ideal, instance["adopted"], instance["latency"], instance["kappa"])


def test_with_the_right_models_it_gives_the_force_of_the_desired_motion_from_the_start():
    assert heard(1.5).error(0.0) < 5e-4


@pytest.mark.parametrize("factor", [0.8, 1.2])
def test_a_wrong_stiffness_is_found_within_a_second(factor):
    found = heard(1.5, scale={"k_m": factor, "k_p": factor})

    assert found.kappa == pytest.approx(factor - 1.0, abs=0.01)


@pytest.mark.parametrize("T_f", [0.007, 0.013])
def test_a_wrong_sensor_lag_is_adopted_as_a_latency(T_f):
    """By f = -y + (T_f - T_f_hat) y' of the believed lag: epsilon = T_f_hat - T_f."""
    found = heard(T_f=T_f)

    assert found.adopted == pytest.approx(0.01 - T_f, abs=4e-4)


def test_a_latency_is_not_adopted_before_it_has_been_seen_for_a_cycle():
    assert heard(1.1, T_f=0.013).adopted == 0.0


@pytest.mark.parametrize("factor", [0.7, 1.3])
def test_with_the_sensor_trusted_a_wrong_damping_is_part_of_the_force(factor):
    scale = {"c_m": factor, "c_p": factor}

    trusted = heard(scale=scale, latency_tolerance=0.0)

    assert trusted.adopted == pytest.approx((factor - 1.0) * LOSS, rel=0.06)
    assert trusted.error(3.0) < 2e-3


@pytest.mark.parametrize("factor", [0.7, 1.3])
def test_in_doubt_an_error_of_time_that_the_damping_explains_is_damping(factor):
    found = heard(1.8, scale={"c_m": factor, "c_p": factor})

    assert found.latency == 0.0
    assert found.adopted == pytest.approx((factor - 1.0) * LOSS, rel=0.05)


def test_in_doubt_an_error_of_time_beyond_two_deviations_of_the_damping_is_a_latency():
    """By hand: t_s = 2.23 ms, exp(-0.4) - 1 = -0.33: -0.74 ms is the least that damping explains."""
    within, beyond = heard(1.8, T_f=0.0105), heard(1.8, T_f=0.011)

    assert within.latency == 0.0
    assert beyond.latency == pytest.approx(-1e-3, abs=1e-4)


def test_a_declared_tolerance_shares_an_error_of_time_by_the_variances():
    """By hand: 0.5 ms of the sensor, 0.2 t_s = 0.447 ms of the damping: w_T = 0.556."""
    found = heard(1.8, scale={"c_m": 1.3, "c_p": 1.3}, latency_tolerance=5e-4)

    assert found.latency / found.adopted == pytest.approx(0.556, abs=0.001)


def test_with_all_tolerances_zero_nothing_is_adopted():
    none = {
        "latency_tolerance": 0.0,
        "damping_tolerance": 0.0,
        "stiffness_tolerance": 0.0,
        "stiffness_rate": 0.0,
    }
    found = heard(2.0, T_f=0.013, scale={"k_p": 1.2}, **none)

    assert (found.adopted, found.kappa) == (0.0, 0.0)


def test_half_the_first_force_where_it_is_asked_for():
    whole, half = heard(0.01), heard(0.01, half_first_force=True)

    assert half.force[0] == pytest.approx(whole.force[0] / 2.0, rel=1e-12)
    assert half.force[1] == pytest.approx(whole.force[1], rel=1e-12)


def test_white_noise_of_the_force_is_measured():
    """Independent numbers: sigma of the generator."""
    instance = Instance(load("robust"))
    instance.initialise()
    found = []
    for k, n in enumerate(np.random.default_rng(2).normal(scale=0.5, size=3000)):
        instance["f_mea"] = n
        instance.step(k * T, T)
        found.append(instance["noise"])

    assert np.sqrt(np.mean(found[1000:])) == pytest.approx(0.5, rel=0.05)


def tracking_error(numerator, denominator, frequencies, **values):
    """
    Move a plant by `robust`, along cosines of one amplitude; give the largest error after 2 s of 4.

    The plant is integrated by SciPy; the command takes effect a period after it is set, held.
    """
    plant = signal.cont2discrete(signal.tf2ss(numerator, denominator), T, "zoh")
    A, B, C = plant[0], plant[1][:, 0], plant[2][0]
    x = np.linalg.solve(np.eye(len(A)) - A, B) * AMPLITUDE * len(frequencies)
    line = [AMPLITUDE * len(frequencies)] * 2
    instance = Instance(load("robust"))
    for name, value in {**CONTACT, "m_s": STIFFNESS / W**2, "T_f_hat": 0.0, **values}.items():
        instance[name] = value
    error = []
    for k in range(4000):
        waves = [(w, AMPLITUDE * math.cos(w * k * T)) for w in frequencies]
        s = sum(wave for _, wave in waves)
        instance["s_des"], instance["s_act"], instance["f_mea"] = s, C @ x, -STIFFNESS * (C @ x)
        instance["a_des"] = -sum(w * w * wave for w, wave in waves)
        if k == 0:
            instance.initialise()
        error.append(C @ x - s)
        instance.step(k * T, T)
        line.append(instance["s_cmd"])
        x = A @ x + B * line.pop(0)
    return max(np.abs(error[2000:]))


@pytest.mark.parametrize("slower", [0.8, 1.2])
def test_a_motion_simulator_that_is_not_as_believed_is_led_by_what_it_lacks(slower):
    """K_p and w_v of 30/slower, 125.7/slower."""
    K_p, w_v, z = 30.0 / slower, 40.0 * math.pi / slower, 0.8

    error = tracking_error([K_p * w_v**2], [1.0, 2.0 * z * w_v, w_v**2, K_p * w_v**2], [W])

    assert error < 0.004 * AMPLITUDE


def test_a_plant_with_one_coefficient_off_is_led_at_two_frequencies_where_its_error_is_parallel():
    """1/M + 0.02 + 6 ms s: K_p w_v^2 (0.02 + 6 ms s) more in the denominator."""
    K_p, w_v, z = 30.0, 40.0 * math.pi, 0.8
    gain = K_p * w_v**2
    denominator = [1.0, 2.0 * z * w_v, w_v**2 + 0.006 * gain, 1.02 * gain]
    told = {"uses_a_des": True, "plant_prefilter": 12.0}

    series, parallel = (
        tracking_error([gain], denominator, [W, 3.0 * W], plant_error=error, **told) for error in (1, 2)
    )

    assert parallel < 0.01 * AMPLITUDE
    assert series > 3.0 * parallel


def test_with_the_sensor_trusted_nothing_is_kept_to_be_undone():
    """On a light mass with a stiff contact the sensitivity to a latency would grow without bound."""
    instance = Instance(load("robust"))
    for name, value in {"contact": 2, "k_m": 5e6, "m_s": 1.0, "latency_tolerance": 0.0}.items():
        instance[name] = value
    instance.initialise()
    for k in range(200):
        instance["s_act"] = 1e-3 * math.cos(W * k * T)
        instance.step(k * T, T)

    assert (instance["x_t"], instance["v_t"]) == (0.0, 0.0)
    assert math.isfinite(instance["f_comp"])
