from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import expm

from fmu_sources.force_sensor.force_sensor import MODEL
from fmu_sources.force_sensor.noise import M1, M2, seeded, uniform
from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.instance import Instance, ModelError
from fmu_sources.framework.variables import Role

T = 1e-3


def make(**values):
    instance = Instance(MODEL)
    for name, value in values.items():
        instance[name] = value
    instance.initialise()
    return instance


def measured(sensor, forces):
    rows = []
    for k, f in enumerate(forces):
        sensor["f_act"] = f
        sensor.step(k * T, T)
        rows.append(sensor["f_mea"])
    return np.array(rows)


def test_ports_and_slot():
    assert [v.name for v in MODEL.group(Role.INPUT)] == ["f_act"]
    assert [v.name for v in MODEL.group(Role.OUTPUT)] == ["f_mea"]
    assert [slot.name for slot in MODEL.slots] == ["output"]


def test_it_starts_steady_with_offset_and_noise():
    sensor = make(f_act=300.0, offset=2.0, sigma=0.5)

    assert sensor["f_mea"] == pytest.approx(302.0 + 0.5 * sensor["noise"], rel=1e-15)
    assert sensor["noise"] != 0.0
    assert make(f_act=300.0, sigma=0.0)["f_mea"] == 300.0


def test_a_linear_force_gives_the_exact_lag():
    forces = 100.0 * np.sin(0.3 * np.arange(1, 30)) + 50.0
    sensor = make(sigma=0.0, f_act=50.0, T_f=0.004)
    A = np.array([[-1 / 0.004, 1 / 0.004, 0], [0, 0, 1], [0, 0, 0]])
    y, old, expected = 50.0, 50.0, []
    for new in forces:
        y = (expm(A * T) @ [y, old, (new - old) / T])[0]
        old = new
        expected.append(y)

    assert measured(sensor, forces) == pytest.approx(expected, rel=1e-12)


def test_a_ramp_is_late_by_the_time_constant():
    rows = measured(make(sigma=0.0, T_f=0.01), 1000.0 * T * np.arange(1, 501))

    assert rows[-1] == pytest.approx(1000.0 * (0.5 - 0.01), rel=1e-12)


def test_without_time_constant_the_force_passes():
    forces = np.cos(np.arange(20.0))

    assert (measured(make(sigma=0.0, T_f=0.0, f_act=3.0), forces) == forces).all()


def test_the_generator_is_mrg32k3a():
    state, total = (12345.0,) * 6, 0
    s1, s2 = [12345] * 3, [12345] * 3
    for _ in range(1000):
        u, state = uniform(state, PYTHON)
        s1 = [*s1[1:], (1403580 * s1[1] - 810728 * s1[0]) % int(M1)]
        s2 = [*s2[1:], (527612 * s2[2] - 1370589 * s2[0]) % int(M2)]
        difference = (s1[2] - s2[2]) % int(M1)
        total += u == (difference or int(M1)) * 2.328306549295727688e-10

    assert total == 1000
    assert [int(s) for s in state] == s1 + s2


def test_seeds_give_whole_states_below_the_moduli():
    for seed in (0, 1, 2, 2**31 - 1):
        state = seeded(seed, PYTHON)

        assert all(s == int(s) and 0 < s < M for s, M in zip(state, [M1] * 3 + [M2] * 3, strict=True))


def test_the_noise_is_white_and_normal():
    noise = measured(make(sigma=0.5, T_f=0.0, seed=7), np.zeros(20_000)) / 0.5
    lags = [np.mean(noise[k:] * noise[:-k]) for k in range(1, 6)]
    beyond = np.mean(np.abs(noise) > 1.96)

    assert np.mean(noise) == pytest.approx(0.0, abs=4 / math.sqrt(len(noise)))
    assert np.std(noise) == pytest.approx(1.0, abs=4 / math.sqrt(2 * len(noise)))
    assert lags == pytest.approx([0.0] * 5, abs=4 / math.sqrt(len(noise)))
    assert beyond == pytest.approx(0.05, abs=4 * math.sqrt(0.0475 / len(noise)))


def test_seeds_are_uncorrelated():
    a, b = (measured(make(sigma=1.0, T_f=0.0, seed=seed), np.zeros(5000)) for seed in (1, 2))

    assert np.mean(a * b) == pytest.approx(0.0, abs=4 / math.sqrt(5000))


def test_the_same_seed_gives_the_same_run():
    forces = np.linspace(0.0, 10.0, 50)

    assert (measured(make(seed=3), forces) == measured(make(seed=3), forces)).all()


def test_a_restored_state_continues_the_same_sequence():
    sensor = make(seed=5)
    measured(sensor, np.arange(10.0))
    kept = list(sensor.values)
    first = measured(sensor, np.arange(10.0))
    sensor.values = kept

    assert (measured(sensor, np.arange(10.0)) == first).all()


def test_the_lag_is_declared():
    (delay,) = MODEL.delays

    assert (delay.input, delay.kind, delay.seconds) == ("f_act", "lag", "T_f")


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("T_f", -0.01, "T_f: value not allowed, got -0.01 s, expected at least 0.0"),
        ("sigma", -1.0, "sigma: value not allowed, got -1.0 N, expected at least 0.0"),
        ("seed", -1, "seed: value not allowed, got -1, expected at least 0"),
        ("f_act", math.nan, "f_act: value not allowed, got nan N, expected a finite number"),
    ],
)
def test_a_bad_value_is_refused(name, value, message):
    with pytest.raises(ModelError) as error:
        make(**{name: value})

    assert str(error.value) == message
