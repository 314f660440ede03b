"""The configurations have the values of the paper's tables, which the program holds once."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from fmu_sources.motion_simulator.motion_simulator_linear import MotionSimulatorLinear
from master.reproduce.facts.cases import CASES, PLANTS, config_of
from master.reproduce.facts.parameters import PARAMETERS
from master.reproduce.facts.tables import (
    LINEAR_PLANT,
    STEP,
    STIFFNESS_AMPLITUDE,
    STIFFNESS_FREQUENCY,
    TABLES,
)

CONFIGS = Path(__file__).parents[3] / "configs"
FILES = [(CASES[case].config, case) for case in CASES] + [("time_varying_stiffness", "S2"), ("drag", "S1")]
CONTACT = ("m_e", "k_m", "c_m", "k_p", "c_p")


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize(("name", "case"), FILES)
def test_a_configuration_has_the_values_of_its_table(name, case, plant):
    config = yaml.safe_load((CONFIGS / f"{config_of(name, plant)}.yaml").read_text(encoding="utf-8"))
    values = {fmu: entry.get("parameters", {}) for fmu, entry in config["fmus"].items()}
    table = TABLES[case]
    contact = {key: getattr(table.loop, key) for key in CONTACT}
    varying = {"k_p_amplitude": STIFFNESS_AMPLITUDE, "k_p_frequency": STIFFNESS_FREQUENCY}
    real = contact | varying if name == "time_varying_stiffness" else contact

    assert config["step_size"] == STEP
    assert values["spacecraft"] == {"m_s": table.loop.m_s}
    assert values["contact"] == real
    assert values["ideal"] == {"m_s": table.loop.m_s} | real
    assert {key: values["compensator"][key] for key in CONTACT} == contact
    assert values["force_sensor"] == {"T_f": table.T_f, "sigma": table.sigma, "seed": 1}


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("case", CASES)
def test_a_case_starts_with_the_offset_of_its_table(case, plant):
    file = CONFIGS / f"{config_of(CASES[case].config, plant)}.yaml"
    fmus = yaml.safe_load(file.read_text(encoding="utf-8"))["fmus"]
    starts = [fmus["spacecraft"]["start"]["s_des"], fmus["motion_simulator"]["start"]["s_act"]]

    assert [*starts, fmus["ideal"]["start"]["s"]] == [TABLES[case].offset] * 3


def test_the_linear_motion_simulator_has_the_values_of_the_linear_plant():
    starts = {v.name: v.start for v in MotionSimulatorLinear.variables}

    assert {name: starts[name] for name in vars(LINEAR_PLANT)} == vars(LINEAR_PLANT)


def test_the_page_shows_the_tables_as_they_are():
    shown = {p.symbol: p.values for p in PARAMETERS}

    assert shown["m_s"] == ("820", "1000", "4000", "1000")
    assert shown["k_m"] == ("150 000", "800 000", "139 200", "139 200")
    assert shown["c_m"] == ("158", "800", "136.1", "136.1")
    assert shown["s0"] == ("-10", "-10", "-5", "-5")
    assert shown["T_f"] == ("0", "0", "10", "10")
    assert shown["linear plant"] == ("30 1/s", "125.66 rad/s", "0.8", "2 ms")
