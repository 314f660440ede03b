from __future__ import annotations

import csv
import math

import numpy as np
import pyarrow.parquet
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import find_peaks

from . import COLUMNS, LISTED, SUBSYSTEM, UNLISTED, Effects, Plant, Recorder, T, record
from .plant import N_STATES, SECOND_LAG, derivatives
from .recording import coloured

QUIET = Recorder(sigma=0.0, sigma_s=0.0, sigma_v=0.0, step_f=0.0, step_s=0.0)
SIZES = {
    **{
        "slack": 3e-3,
        "cubic": 2e8,
        "quadratic_stiffness": 2e6,
        "backlash": 5e-5,
        "bouc_wen": 5.0,
        "end_stop": 4e3,
    },
    **{"coulomb": 4.0, "stribeck": 5.0, "dahl": 4.0, "presliding": 4.0, "quadratic_damping": 300.0},
    **{"offset": 1.0, "drift": 0.2, "gain": 0.02, "lag": 2e-3, "delay": 2e-3, "quantisation": 2.0},
    **{"asymmetric_friction": 5.0, "load_friction": 0.05, "ripple": 3.0, "force_limit": 80.0},
    **{"simulator_gain": 0.01, "slow_filter": 2e-3},
    **{
        "inertia": 3.0,
        "mount": 0.5,
        "rate_limit": 0.05,
        "speed_limit": 0.05,
        "simulator_delay": 2.0,
        "spacecraft_offset": 5.0,
    },
    **{"command_quantisation": 2e-4, "correction_saturation": 60.0, "hertz": 2e5, "position_friction": 3.0},
    **{"thermal": 0.05, "preisach": 3.0, "asymmetric_slack": 4e-3, "varying_delay": 4e-3},
}


def test_loop_has_the_damping_and_frequency_of_the_ideal_one():
    s = record(excitation="decay", recorder=QUIET, duration=20.0)["s_des"]
    peaks = find_peaks(s)[0]

    decrement = np.log(s[peaks[0]] / s[peaks[-1]]) / (len(peaks) - 1)
    assert decrement / (2.0 * math.pi) == pytest.approx(0.0062, abs=3e-4)
    assert (len(peaks) - 1) / ((peaks[-1] - peaks[0]) * T) == pytest.approx(0.8749, abs=2e-3)


@pytest.mark.parametrize("kind", ["", "coulomb", "bouc_wen", "slack", "preisach"])
def test_plant_agrees_with_another_solver(kind):
    effects = Effects(**({kind: SIZES[kind]} if kind else {}))
    found = record(effects, recorder=QUIET, duration=0.15)
    p, y, out = Plant(), np.zeros(N_STATES), np.empty(N_STATES)
    y[0], y[3] = -5e-3, p.k_p / (p.k_m + p.k_p) * -5e-3
    y[5] = y[6] = y[SECOND_LAG] = -p.k_m * y[3]
    positions = []
    for k in range(len(found)):
        positions.append(y[0])
        command = found["s_cmd"][k - 2] if k >= 2 else -5e-3

        def law(t, y, command=command):
            derivatives(t, y, command, p, effects, out)
            return out.copy()

        y = solve_ivp(law, (k * T, (k + 1) * T), y, method="LSODA", rtol=1e-9, atol=1e-13).y[:, -1]

    assert np.abs(found["s_act"] - positions).max() < 1e-8


@pytest.mark.parametrize("kind", Effects._fields)
def test_every_effect_changes_the_recording(kind):
    base = record(excitation="rich", recorder=QUIET, duration=3.0)
    changed = record(Effects(**{kind: SIZES[kind]}), excitation="rich", recorder=QUIET, duration=3.0)

    assert len(changed) == len(base)
    assert max(np.abs(changed[name] - base[name]).max() for name in ("f_mea", "s_act", "s_des")) > 1e-5


def test_every_effect_belongs_to_a_subsystem():
    assert set(SUBSYSTEM) == set(Effects._fields) == {*LISTED, *UNLISTED}
    assert SUBSYSTEM["presliding"] == "contact"
    assert SUBSYSTEM["offset"] == SUBSYSTEM["mount"] == "force_sensor"
    assert SUBSYSTEM["simulator_delay"] == "motion_simulator"
    assert SUBSYSTEM["correction_saturation"] == "compensator"
    assert len(UNLISTED) == 6


def test_seed_makes_the_recording():
    first, again, other = (record(seed=seed, duration=1.0)["f_mea"] for seed in (1, 1, 2))

    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


@pytest.mark.parametrize("colour", [0.0, 0.9])
def test_noise_has_its_size_and_colour(colour):
    noise = coloured(np.random.default_rng(3).standard_normal(100_000), colour)

    assert np.std(noise) == pytest.approx(1.0, rel=0.03)
    assert np.corrcoef(noise[1:], noise[:-1])[0, 1] == pytest.approx(colour, abs=0.01)


def test_force_noise_has_the_declared_size():
    recorder = QUIET._replace(sigma=0.5)
    f = record(recorder=recorder, excitation="decay", seed=3, s0=0.0)["f_mea"]

    assert np.std(np.diff(f)) / math.sqrt(2.0) == pytest.approx(0.5, rel=0.03)


def test_recorded_time_hides_the_error_of_the_clock():
    true, wrong = (
        record(excitation="decay", recorder=QUIET._replace(clock_error=error)) for error in (0.0, 0.01)
    )

    assert np.array_equal(true["t"], wrong["t"])
    assert not np.allclose(true["s_act"], wrong["s_act"], atol=2e-6)


def test_wrong_belief_of_the_compensator_changes_the_damping():
    stiff = Plant()._replace(k_p=1.2 * Plant().k_p)
    right, wrong = (record(plant=plant, excitation="decay") for plant in (Plant(), (Plant(), stiff)))

    assert np.abs(wrong["s_des"][-1500:]).max() < 0.8 * np.abs(right["s_des"][-1500:]).max()


def test_converters_work_in_steps():
    recording = record(recorder=Recorder(step_f=0.5, step_s=1e-5), duration=1.0)

    for name, step in (("f_mea", 0.5), ("s_act", 1e-5)):
        counts = recording[name] / step
        assert np.abs(counts - np.round(counts)).max() < 1e-6


def test_files_hold_the_columns(tmp_path):
    recording = record(duration=0.1)
    paths = [recording.write(tmp_path / f"run.{ending}") for ending in ("csv", "npz", "parquet")]

    with paths[0].open() as file:
        rows = list(csv.reader(file))
    assert tuple(rows[0]) == COLUMNS
    assert float(rows[50][6]) == recording["f_mea"][49]
    assert np.array_equal(np.load(paths[1])["s_act"], recording["s_act"])
    assert pyarrow.parquet.read_table(paths[2])["x"].to_pylist() == [0.0] * 100


def test_unknown_excitation_is_refused():
    with pytest.raises(ValueError, match="got 'loud', expected 'decay' or 'rich'"):
        record(excitation="loud")
