from __future__ import annotations

import math

import numpy as np
import pytest

from fmu_sources.compensator.compensator import MODEL
from fmu_sources.compensator.difference import process_parameters
from fmu_sources.compensator.identifiers.framework.catalogue import IdentifierChoice as Identifier
from fmu_sources.compensators.plugs import INPUTS as PLUGS
from fmu_sources.export.dependencies import initial_dependencies
from fmu_sources.framework.instance import ModelError
from fmu_sources.framework.variables import Role
from tests.fmu_sources.compensator.made import OFF, make, parameters, step

OUTPUTS = ["f_des", "s_cmd", "df", "m_e_id", "k_m_id", "c_m_id", "k_p_id", "c_p_id", "attributes_valid"]
OUTPUTS += ["f_comp"]  # f_des by the name that all methods have for it


def test_ports():
    states = [v for v in MODEL.group(Role.STATE) if v.output]

    assert [v.name for v in MODEL.group(Role.INPUT)] == [v.name for v in PLUGS]
    assert [v.name for v in MODEL.group(Role.OUTPUT)] == OUTPUTS
    assert [v.name for v in states] == ["a", "b", "c", "d", "e", "f_lead"]
    assert [slot.name for slot in MODEL.slots] == ["force_correction", "command"]


def test_choices_take_the_names_of_the_users():
    items = {v.name: [item.name for item in v.items] for v in MODEL.group(Role.PARAMETER) if v.items}

    assert items == {
        "identifier": ["kalman", "rls", "fixed"],
        "preset": ["custom", "L", "F"],
        "difference_method": ["backward", "forward", "bilinear"],
        "gain_convention": ["paper", "unit_dc"],
    }


def test_it_starts_steady():
    compensator = make(s_des=-0.01, s_act=-0.01, f_mea=302.0)
    alpha = (1 + math.sin(compensator["dpdc_phase"])) / (1 - math.sin(compensator["dpdc_phase"]))

    assert (compensator["f_des"], compensator["df"]) == (302.0, 0.0)
    assert compensator["s_cmd"] == pytest.approx(-0.01 / math.sqrt(alpha), rel=1e-14)
    started = compensator["s_cmd"]
    for k in range(20):
        step(compensator, k)
    assert compensator["f_des"] == pytest.approx(302.0, rel=1e-12)
    assert compensator["s_cmd"] == pytest.approx(started, rel=1e-12)


def test_switched_off_it_passes_force_and_displacement():
    compensator = make(**OFF)
    for k in range(10):
        step(compensator, k, s_des=0.001 * k, s_act=-0.002 * k, f_mea=3.0 * k)

        assert (compensator["f_des"], compensator["s_cmd"], compensator["df"]) == (3.0 * k, 0.001 * k, 0.0)


def test_one_period_by_hand():
    compensator = make(
        identifier=Identifier.fixed, dpdc=False, s_des=0.01, s_act=0.008, f_mea=10.0, T_f_hat=0.005
    )
    step(compensator, 0, s_des=0.011, s_act=0.0085, f_mea=11.0)
    _, _, c, d, e = process_parameters(parameters("S1"), 1.0)
    dF = -(c * 0.0025 + d * 0.002 + e * 0.002)

    assert compensator["f_lead"] == pytest.approx(11.0 + 5.0 * 1.0)
    assert compensator["df"] == pytest.approx(dF)
    assert compensator["f_des"] == pytest.approx(16.0 + dF)


def test_held_identification_keeps_what_it_has_learned_and_goes_on_from_there():
    held, free = make(m_e=50.0), make(m_e=50.0)
    for k in range(200):
        s = 0.001 * math.sin(0.1 * k)
        for compensator in (held, free):
            compensator["identification_held"] = float(compensator is held and 50 <= k < 150)
            rests = 50 <= k < 150
            step(compensator, k, s_act=0.0 if rests else s, s_des=0.0 if rests else s, f_mea=-30e3 * s)
        if k == 49:
            learned = [held[n] for n in "abcde"]
        if k == 149:
            kept, moved = ([c[n] for n in "abcde"] for c in (held, free))

    assert kept == learned != moved
    assert [held[n] for n in "abcde"] != learned


def test_the_drag_travel_takes_part_in_the_identification_only():
    moved, still = make(x=0.003, s_act=0.003), make()
    for k in range(50):
        s = 0.001 * math.sin(0.1 * k)
        step(moved, k, s_act=0.003 + s, s_des=0.003 + s, x=0.003, f_mea=-30e3 * s)
        step(still, k, s_act=s, s_des=s, f_mea=-30e3 * s)

    assert [moved[n] for n in "abcde"] == pytest.approx([still[n] for n in "abcde"], rel=1e-9)


def test_effects_reach_force_and_command_but_not_the_recursion():
    compensator = make(identifier=Identifier.fixed, dpdc=False)
    step(compensator, 0, s_des=0.01)
    x, u, p = (
        kind.record(compensator.values[place])
        for kind, place in (
            (MODEL.states, compensator._x),
            (MODEL.inputs, compensator._u),
            (MODEL.parameters, compensator._p),
        )
    )
    y = MODEL.outputs(0.0, x, u, p, compensator.m, slot=lambda name, value, **signals: 2.0 * value)

    assert y["df"] == pytest.approx(2.0 * compensator["df"])
    assert y["f_des"] == pytest.approx(2.0 * compensator["df"])
    assert y["s_cmd"] == pytest.approx(0.02)


def test_no_start_value_branches_on_a_signal():
    found = initial_dependencies(MODEL)

    assert "f_mea" in found["f_des"]
    assert "s_des" in found["s_cmd"]


@pytest.mark.parametrize("identifier", Identifier)
def test_wild_inputs_give_finite_outputs(identifier):
    compensator = make(identifier=identifier, forgetting_factor=0.9)
    rng = np.random.default_rng(3)
    for k in range(500):
        s_des, s_act, f_mea, x = rng.normal(size=4) * 10.0 ** rng.integers(-6, 6)
        step(compensator, k, s_des=s_des, s_act=s_act, f_mea=f_mea, x=x)

        assert not any(math.isnan(compensator[name]) for name in [*OUTPUTS, *"abcde"])


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("m_e", 0.0, "m_e: value not allowed, got 0.0 kg, expected above 0.0"),
        ("R", 0.0, "R: value not allowed, got 0.0 N2, expected above 0.0"),
        ("forgetting_factor", 1.5, "forgetting_factor: value not allowed, got 1.5, expected at most 1.0"),
        ("T_f_hat", -1.0, "T_f_hat: value not allowed, got -1.0 s, expected at least 0.0"),
        ("dpdc_phase", 1.6, "dpdc_phase: value not allowed, got 1.6 rad, expected at most 1.5"),
        ("preset", 7, "preset: value not allowed, got 7, expected one of 1 (custom), 2 (L), 3 (F)"),
        ("s_act", math.nan, "s_act: value not allowed, got nan m, expected a finite number"),
    ],
)
def test_a_bad_value_is_refused(name, value, message):
    with pytest.raises(ModelError) as error:
        make(**{name: value})

    assert str(error.value) == message
