"""Commissioning: what a chirp tells, how sure that is, and what it says where the model lacks something."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.signal import lsim

from master.api import prepare_to_run
from master.cli import main
from master.commissioning.beliefs import beliefs
from master.commissioning.chirp import REST_AFTER, REST_BEFORE, Chirp
from master.commissioning.commission import commission
from master.commissioning.models import Knowledge
from master.commissioning.rig import run_held
from master.comparison.cells import Cell
from master.comparison.compare import Task, scores
from master.comparison.methods import all_methods
from master.experiment.prepare import Request
from tests.costs import long_for

E2 = Path(__file__).parents[3] / "configs" / "experiment_1000kg.yaml"
T = 1e-3
HIGHEST = 18.0
CONTACT = {"m_e": 100.0, "k_m": 139200.0, "c_m": 136.1, "k_p": 37760.0, "c_p": 97.3}
PLANT = {"K_p": 30.0, "w_v": 40.0 * math.pi, "z": 0.8, "dead_time": 0.002}
WRONG = {
    **{"m_e": 100.0, "k_m": 1.2 * 139200.0, "k_p": 1.2 * 37760.0, "c_m": 0.7 * 136.1, "c_p": 0.7 * 97.3},
    **{"T_f": 0.007, "K_p": 25.0, "w_v": 110.0, "z": 0.7, "dead_time": 0.003},
}
OF_FMUS = Knowledge(T, interpolations=2.0, spread=0.01, force_zero=0.0)
TRUE_K = 139200.0 * 37760.0 / 176960.0
TRUE_C = TRUE_K * (136.1 / 139200.0 + 97.3 / 37760.0 - 233.4 / 176960.0)
TRUE = {**CONTACT, **PLANT, "T_f": 0.01, "k": TRUE_K, "c": TRUE_C, "lag": 1.0 / 30.0 + 0.002}


@cache
def clean():
    """Record of the FMUs without noise."""
    return run_held(prepare_to_run(E2, Request(assignments=("force_sensor.sigma=0",))), Chirp())


def noisy(sigma, seed, held=None):
    held = held or clean()
    return replace(held, f_mea=held.f_mea + sigma * np.random.default_rng(seed).normal(size=len(held.f_mea)))


@pytest.mark.parametrize(
    ("sigma", "T_f", "c", "k"),
    long_for(
        [(5.0, 7e-4, 0.13, 0.001)],
        [(0.03, 3e-5, 0.005, 0.001), (0.5, 2e-4, 0.06, 0.001), (5.0, 7e-4, 0.13, 0.001)],
    ),
)
def test_parameters_and_deviations_hold_from_a_wrong_belief(sigma, T_f, c, k):
    for seed in (11, 12):
        found = commission(noisy(sigma, seed), WRONG, HIGHEST, OF_FMUS)

        assert found["T_f"].value == pytest.approx(0.01, abs=T_f)
        assert found["c"].value == pytest.approx(TRUE_C, rel=c)
        assert found["k"].value == pytest.approx(TRUE_K, rel=k)
        assert found["delay"].value == 0.0
        for name in PLANT:
            assert found[name].value == pytest.approx(PLANT[name], rel=0.005)
        for name in ("T_f", "c", "k", "k_m", "k_p", "c_m", "c_p", "lag", "K_p"):
            assert abs(found[name].value - TRUE[name]) < 3.5 * found[name].deviation, name
        assert found.contact.noise == pytest.approx(sigma, rel=0.05)
        assert not any("lacks" in warning for warning in found.warnings)


def test_the_force_at_rest_counts_as_much_as_its_zero_is_known():
    """5 N leave the chirp 0.3 % of k; 148.5 N at rest are as many per cent of it as their zero is unsure."""
    deviations = []
    for zero in (math.inf, 0.75, 0.0):
        found = commission(noisy(5.0, 13), WRONG, HIGHEST, replace(OF_FMUS, force_zero=zero))
        assert abs(found["k"].value - TRUE_K) < 3.0 * found["k"].deviation
        deviations.append(found["k"].deviation / TRUE_K)

    alone = deviations[0]
    at_rest = math.hypot(0.75, 5.0 / math.sqrt(8001), 3e-4 * 148.5) / 148.5
    assert alone == pytest.approx(0.0031, abs=0.0003)
    assert deviations[1] == pytest.approx((alone**-2 + at_rest**-2) ** -0.5, rel=0.05)
    assert deviations[2] < 0.0006


def test_a_force_at_rest_that_the_chirp_contradicts_is_left_out_and_said():
    """A sensor that shows 3 N too much at rest, where its zero is said to be known to 0.1 N: 2 % of k."""
    shifted = replace(clean(), f_mea=clean().f_mea + 3.0)
    believed = commission(noisy(0.5, 5, shifted), WRONG, HIGHEST, replace(OF_FMUS, force_zero=0.1))
    alone = commission(noisy(0.5, 5, shifted), WRONG, HIGHEST, replace(OF_FMUS, force_zero=math.inf))

    assert believed["k"] == alone["k"]
    assert any(w.startswith("the force at rest is ") and "left out" in w for w in believed.warnings)
    assert not any("at rest" in w for w in alone.warnings)

    unsure = commission(noisy(0.5, 5, shifted), WRONG, HIGHEST, replace(OF_FMUS, force_zero=3.0))
    assert not any("at rest" in w for w in unsure.warnings)
    assert abs(unsure["k"].value - TRUE_K) < 3.0 * unsure["k"].deviation


@pytest.mark.long
def test_without_noise_the_fmus_are_found_as_they_are():
    found = commission(clean(), WRONG, HIGHEST, OF_FMUS)

    for name in ("T_f", "c", "k"):
        assert found[name].value == pytest.approx(TRUE[name], rel=1e-4)


def test_a_rig_that_is_no_fmu_is_found_too():
    """Contact and sensor integrated at 20 kHz between smooth samples, by another program's linear solver."""
    held = clean()
    m_e, k_m, c_m, k_p, c_p = (CONTACT[n] for n in ("m_e", "k_m", "c_m", "k_p", "c_p"))
    numerator = -np.polymul([c_m, k_m], [c_p, k_p])
    denominator = np.polymul([m_e, c_m + c_p, k_m + k_p], [0.01, 1.0])
    t = T * np.arange(len(held.s_act))
    fine = np.arange(0.0, t[-1], T / 20.0)
    motion = np.interp(fine, t, held.s_act - held.s_act[0])
    _, force, _ = lsim((numerator, denominator), motion, fine)
    record = noisy(0.03, 4, replace(held, f_mea=np.interp(t, fine, force)))

    found = commission(record, WRONG, HIGHEST, Knowledge(T))

    for name in ("T_f", "c", "k"):
        assert abs(found[name].value - TRUE[name]) < 3.0 * found[name].deviation, name
    assert found["T_f"].deviation < 5e-5


def test_a_delay_of_the_force_is_told_from_the_lag_of_the_sensor():
    held = clean()
    late = np.concatenate([held.f_mea[:1], held.f_mea[:-1]])

    found = commission(noisy(0.03, 7, replace(held, f_mea=late)), WRONG, HIGHEST, OF_FMUS)

    assert found["delay"].value == pytest.approx(1e-3, abs=5e-5)
    assert found["T_f"].value == pytest.approx(0.01, abs=5e-5)
    assert found.parameters()["T_f_hat"] == found["T_f"].value + found["delay"].value
    assert any("late by more than the sensor's lag" in warning for warning in found.warnings)


def test_what_the_model_lacks_is_said():
    """Friction of 2 N with the sign of the velocity, over a noise of 0.03 N."""
    held = clean()
    velocity = np.gradient(held.s_act, T)
    rubbing = replace(held, f_mea=held.f_mea - 2.0 * np.tanh(velocity / 1e-4))

    found = commission(noisy(0.03, 3, rubbing), WRONG, HIGHEST, OF_FMUS)

    assert found.contact.ratio > 1.5
    assert any(w.startswith("s_act to f_mea: the fit leaves") for w in found.warnings)


@pytest.mark.long
def test_a_ratio_that_is_not_as_believed_is_said():
    wrong = {**WRONG, "k_m": 2.0 * WRONG["k_m"]}

    found = commission(noisy(0.03, 3), wrong, HIGHEST, OF_FMUS)

    assert any(w.startswith("k_m/k_p: ") for w in found.warnings)


def test_the_chirp_is_at_rest_at_both_ends_and_no_larger_than_asked():
    chirp = Chirp(amplitude=3e-4, duration=4.0, lowest=1.0, highest=8.0)
    s = chirp.samples(T)

    assert len(s) == round((REST_BEFORE + 4.0 + REST_AFTER) / T) + 1
    assert not s[: round(REST_BEFORE / T)].any()
    assert abs(s[-round(REST_AFTER / T) :]).max() < 1e-15
    assert 2.9e-4 < abs(s).max() <= 3e-4
    crossings = np.count_nonzero(np.diff(np.sign(s[np.abs(s) > 1e-9])))
    assert crossings == pytest.approx(2.0 * 4.0 * (1.0 + 8.0) / 2.0, abs=2)


def test_a_fit_begins_with_what_the_compensator_believes_and_not_with_the_rig():
    assignments = ("contact.k_m=200000", "force_sensor.T_f=0.02", "motion_simulator.K_p=20")
    found = beliefs(prepare_to_run(E2, Request(assignments=assignments)))

    assert (found["k_m"], found["T_f"], found["K_p"]) == (139200.0, 0.01, 30.0)


def call(tmp_path, *options):
    file = tmp_path / "rig" / "parameters.ssv"
    answer = CliRunner().invoke(main, ["commission", str(E2), "--output", str(file), "--json", *options])
    return answer.exit_code, json.loads(answer.stdout), file


def test_the_command_writes_parameters_page_and_chirp_and_reads_a_recording(tmp_path):
    exit_status, found, file = call(tmp_path)

    assert exit_status == 0
    written = {p.get("name"): float(p[0].get("value")) for p in ET.parse(file).getroot()[0]}
    assert written == found["parameters"]
    assert {"T_f_hat", "latency_tolerance", "K_p", "k_m"} <= set(written)
    assert written["latency_tolerance"] == found["values"]["T_f"]["deviation"]
    page = (file.parent / "commission.html").read_text(encoding="utf-8")
    assert "What the rig is" in page
    chirp = np.genfromtxt(file.parent / "chirp.csv", delimiter=",", names=True)
    assert chirp["s_cmd"] == pytest.approx(Chirp().samples(T), abs=1e-12)

    held = noisy(0.03, 9)
    table = np.column_stack([T * np.arange(len(held.s_cmd)), held.s_cmd, held.s_act, held.f_mea])
    recording = tmp_path / "rig.csv"
    np.savetxt(recording, table, delimiter=",", header="time,s_cmd,s_act,f_mea", comments="", fmt="%.12g")
    exit_status, found, _ = call(tmp_path, "--record", str(recording), "--method", "inverse3")
    assert exit_status == 0
    assert found["values"]["T_f"]["value"] == pytest.approx(0.01, abs=6e-5)
    assert "latency_tolerance" not in found["parameters"]

    noisier = noisy(5.0, 9)
    table[:, 3] = noisier.f_mea
    np.savetxt(recording, table, delimiter=",", header="time,s_cmd,s_act,f_mea", comments="", fmt="%.12g")
    deviations = []
    for options in ([], ["--force-zero", "0"]):
        _, found, _ = call(tmp_path, "--record", str(recording), *options)
        deviations.append(found["values"]["k"]["deviation"])
    assert deviations[1] < 0.3 * deviations[0]


def test_a_recording_without_a_column_and_a_wrong_method_are_refused(tmp_path):
    recording = tmp_path / "rig.csv"
    recording.write_text("time,s_cmd,f_mea\n" + "".join(f"{k * T:g},0,0\n" for k in range(600)))
    exit_status, found, _ = call(tmp_path, "--record", str(recording))
    assert exit_status == 2
    assert "column for s_act" in found["problems"][0]

    exit_status, found, _ = call(tmp_path, "--highest", "200")
    assert exit_status == 2
    [problem] = found["problems"]
    assert problem.startswith("--highest: too high for the samples, got 200 Hz with a sample every 0.001 s")
    assert problem.endswith("expected at most 166.7 Hz")

    exit_status, found, _ = call(tmp_path, "--method", "nothing")
    assert exit_status == 2
    assert "no such method" in found["problems"][0]


@pytest.mark.long
@pytest.mark.parametrize(
    ("changes", "bound"),
    [
        ({"force_sensor.T_f": 0.013}, 0.3),
        ({"motion_simulator.K_p": 25.0, "motion_simulator.w_v": 105.0}, 0.3),
        (
            {
                **{f"{name}.k_m": 167040.0 for name in ("contact", "ideal")},
                **{f"{name}.k_p": 45312.0 for name in ("contact", "ideal")},
                **{"motion_simulator.K_p": 27.27, "motion_simulator.w_v": 114.24},
                **{"force_sensor.T_f": 0.012, "force_sensor.sigma": 0.5},
            },
            0.8,
        ),
    ],
)
def test_a_compensator_that_is_told_reproduces_the_docking(changes, bound):
    """NRMSE in percent of a rig that is not as believed, after its commissioning."""
    robust = all_methods()["robust"]
    experiment = prepare_to_run(E2, Request(assignments=tuple(f"{k}={v}" for k, v in changes.items())))
    found = commission(run_held(experiment, Chirp()), beliefs(experiment), HIGHEST, OF_FMUS)
    told = {name: value for name, value in found.parameters().items() if name in robust.takes()}

    [result] = scores([Task(E2, "told", Cell(set=changes, told=told), robust, (1,))])

    assert result.s_des is not None
    assert max(result.s_des, result.s_act) <= bound
