"""All methods have the same plugs; each does what its formula says."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

import fmu_sources
from fmu_sources.compensators import plugs
from fmu_sources.composed.registry import load, model_files
from fmu_sources.framework.instance import Instance
from fmu_sources.framework.variables import Role

FOLDER = Path(fmu_sources.__file__).parent / "compensators"
METHODS = [name for name, path in model_files().items() if path.parent == FOLDER]
PREDICTING = ("amb", "ats", "inverse3", "qi", "robust", "smith", "tdpa")
T = 1e-3
each_method = pytest.mark.parametrize("name", METHODS)


def started(name, **values):
    instance = Instance(load(name))
    for key, value in values.items():
        instance[key] = value
    instance.initialise()
    return instance


def stepped(instance, k, **inputs):
    for key, value in inputs.items():
        instance[key] = value
    instance.step(k * T, T)
    return instance["f_comp"], instance["s_cmd"]


@each_method
def test_inputs_outputs_and_terminals_are_the_plugs(name):
    model = load(name)
    shown = [v for v in model.all_variables if v.output or v.role is Role.OUTPUT]

    assert model.group(Role.INPUT) == plugs.INPUTS
    assert [(v.name, v.unit) for v in shown] == [("f_comp", "N"), ("s_cmd", "m")]
    assert model.terminals == plugs.TERMINALS
    assert model.sample_time == "sample_time"


@each_method
def test_terminals_name_variables_that_exist(name):
    names = {v.name for v in load(name).all_variables}

    assert {v for t in load(name).terminals for v in t.members.values()} <= names


@pytest.mark.parametrize("name", [name for name in METHODS if name not in PREDICTING])
def test_at_rest_without_delay_to_undo_a_method_changes_nothing(name):
    instance = started(name, s_des=0.01, s_act=0.01, f_mea=-30.0)

    assert (instance["f_comp"], instance["s_cmd"]) == (-30.0, 0.01)
    assert stepped(instance, 0) == (-30.0, 0.01)


@pytest.mark.parametrize("name", PREDICTING)
def test_without_force_and_elongation_a_predicting_method_changes_nothing(name):
    """These lead the motion that the force is about to make, so that rest is where there is no force."""
    instance = started(name, s_des=0.01, s_act=0.01, x=0.01)

    assert (instance["f_comp"], instance["s_cmd"]) == (0.0, 0.01)
    for k in range(20):
        assert stepped(instance, k) == pytest.approx((0.0, 0.01), abs=1e-15)


def test_the_virtual_damper_brakes_with_stiffness_times_latency():
    instance = started("virtual_damper", stiffness=2000.0, latency=0.03)

    assert stepped(instance, 0, f_mea=5.0, v_des=0.1, s_des=0.02) == pytest.approx((5.0 - 60.0 * 0.1, 0.02))


def test_the_virtual_damper_undoes_a_small_delay_of_a_spring_to_second_order():
    """f_mea = -k s(t - tau): what is left is k s (w tau)^2/2 and no more than that."""
    k, tau, w, amplitude = 2000.0, 0.01, 6.0, 0.01
    instance = started("virtual_damper", stiffness=k, latency=tau)
    left = []
    for i in range(1000):
        t = i * T
        f_mea = -k * amplitude * math.sin(w * (t - tau))
        f, _ = stepped(instance, i, f_mea=f_mea, v_des=amplitude * w * math.cos(w * t))
        left.append(f + k * amplitude * math.sin(w * t))

    assert max(map(abs, left)) == pytest.approx(k * amplitude * (w * tau) ** 2 / 2.0, rel=0.03)


def test_the_virtual_force_gives_the_force_of_the_desired_displacement():
    k = 30_000.0
    instance = started("virtual_force", stiffness=k)

    assert stepped(instance, 0, f_mea=-k * 0.008, s_act=0.008, s_des=0.01) == pytest.approx((-k * 0.01, 0.01))


def test_the_force_lead_undoes_a_lag_of_first_order():
    """The lag by backward difference, f = (T f_act + tau f_last)/(T + tau), is undone exactly."""
    tau, f = 0.02, 0.0
    instance = started("force_lead", latency=tau)
    found, forces = [], np.sin(0.02 * np.arange(300))
    for i, f_act in enumerate(forces):
        f = (T * f_act + tau * f) / (T + tau)
        found.append(stepped(instance, i, f_mea=f)[0])

    assert found == pytest.approx(forces, abs=1e-12)


def test_the_force_lead_amplifies_noise_as_it_says():
    """Variance (1 + r)^2 + r^2 with r = latency/T, as in the docstring."""
    instance = started("force_lead")
    noise = np.random.default_rng(1).normal(size=20_000)
    found = [stepped(instance, i, f_mea=n)[0] for i, n in enumerate(noise)]

    r = instance["latency"] / T
    assert np.std(found[1:]) == pytest.approx(math.sqrt(1.0 + 2.0 * r + 2.0 * r * r), rel=0.02)
    assert math.sqrt(1.0 + 2.0 * r + 2.0 * r * r) == pytest.approx(64.4, abs=0.1)


def test_the_defaults_are_those_of_the_default_loop():
    contact = {v.name: v.start for v in load("docking_contact").group(Role.PARAMETER)}
    k_m, k_p = contact["k_m"], contact["k_p"]

    assert pytest.approx(k_m * k_p / (k_m + k_p), rel=1e-4) == plugs.STIFFNESS.start


def test_the_table_of_methods_names_each_once():
    rows = re.findall(r"^\| `(\w+)\.py` \|", (FOLDER / "README.md").read_text(), re.MULTILINE)

    assert sorted(rows) == sorted([*METHODS, "plant", "plugs"])
