"""Pre-flight: its damping is that of simulations and of a matrix from the paper's equations alone."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from master.analysis.closed_loop.linearise import changed, frozen
from master.api import prepare_to_run
from master.catalogue import silent
from master.cli import main
from master.commissioning.box import Box, default_box, own_values, read_box
from master.commissioning.methods import prepared_methods
from master.commissioning.preflight import in_loops, preflight
from master.comparison.methods import all_methods
from master.errors import ConfigError
from master.evaluation.modes import dominant_mode
from master.experiment.prepare import Request
from master.stepping.simulate import simulate
from tests.costs import long_for
from tests.systems.closed_loop_matrix import damping, loop_matrix

CONFIGS = Path(__file__).parents[3] / "configs"
E2 = CONFIGS / "experiment_1000kg.yaml"
AGREEMENT = 2e-4
QUICK = ("robust",)
CORNER = {
    "box": {
        "stiffness": {"multiplies": ["contact.k_m", "contact.k_p"], "from": 0.8, "to": 1.1},
        "lag": {"divides": ["motion_simulator.K_p", "motion_simulator.w_v"], "from": 0.95, "to": 1.05},
    },
    "points": 2,
}


def box(**changes):
    return Box.model_validate({**CORNER, **changes})


def prepared(method, config=E2):
    [one] = prepared_methods(config, Request(), method, silent)
    return one.experiment


def simulated(experiment, box, factors, seconds=15.0):
    """Damping of a run without noise, in which nothing adapts."""
    system, _ = frozen(experiment.system, after_run=False)
    own = own_values(box, experiment.system)
    changes = {"force_sensor.sigma": 0.0}
    for name, factor in factors.items():
        changes |= box.box[name].changes(factor, own)
    grid = replace(experiment.grid, n_ticks=round(seconds / experiment.grid.step_size))
    outcome = simulate(changed(system, changes), experiment.schedule, grid)
    mode = dominant_mode(outcome.result["spacecraft.s_des"][2000:], grid.step_size)
    return mode.zeta


METHODS = tuple(all_methods())


@pytest.mark.parametrize("method", long_for([m for m in METHODS if m not in QUICK], METHODS))
def test_the_damping_is_that_of_a_simulation_for_each_method(method):
    experiment = prepared(method)
    found = preflight(experiment, box(), method)

    assert len(found.plants) == 4
    for plant in (found.plants[0], found.plants[3]):
        assert abs(simulated(experiment, box(), plant.factors) - plant.zeta) < AGREEMENT


def test_the_damping_is_that_of_the_papers_equations():
    """The paper's compensator with its process parameters held; every plant from matrix exponentials."""
    experiment = prepare_to_run(E2, Request(variant="cfdc_fmdc"))
    contact = {"m_e": 100.0, "k_m": 139200.0, "c_m": 136.1, "k_p": 37760.0, "c_p": 97.3}
    only_rig = Box.model_validate(
        {"box": {"mass": {"multiplies": ["spacecraft.m_s"], "from": 0.7, "to": 1.3}}, "points": 3}
    )

    found = preflight(experiment, only_rig, "paper")

    for plant in found.plants:
        m_s = 1000.0 * plant.factors["mass"]
        matrix = loop_matrix(m_s, contact, 0.01, cfdc=True, fmdc=True)
        assert plant.zeta == pytest.approx(damping(matrix, plant.frequency), abs=2e-6)


@pytest.mark.long
def test_a_box_of_beliefs_is_not_one_of_the_rig():
    """Worst zeta of `robust` over wrong beliefs, rig as configured: 0.0025 by an independent program."""
    of_beliefs = {
        "stiffness": {"multiplies": ["compensator.k_m", "compensator.k_p"], "from": 0.8, "to": 1.2},
        "damping": {"multiplies": ["compensator.c_m", "compensator.c_p"], "from": 0.7, "to": 1.3},
        "lag": {"divides": ["compensator.K_p", "compensator.w_v"], "from": 0.8, "to": 1.2},
    }

    found = preflight(prepared("robust"), Box.model_validate({"box": of_beliefs, "points": 2}), "robust")

    assert found.worst.zeta == pytest.approx(0.0025, abs=5e-5)
    assert found.worst.factors == {"stiffness": 1.2, "damping": 1.3, "lag": 1.2}


@pytest.mark.long
def test_the_latency_is_where_the_loop_begins_to_grow():
    """A whole tick of delay more at a time: stable below the margin and not above it."""
    experiment = prepared("inverse3")
    found = preflight(experiment, box(), "inverse3").nominal

    for ticks in (2, 3):
        wires = tuple(
            replace(w, delay=ticks) if w.target.name == "force_sensor.f_act" else w
            for w in experiment.system.wires
        )
        late = replace(experiment, system=replace(experiment.system, wires=wires))
        zeta = preflight(late, box(), "inverse3").nominal.zeta
        assert (zeta > 0.0) == (1e-3 * ticks < found.later)
    assert found.later == pytest.approx(2.0 * found.zeta / (2.0 * math.pi * found.frequency), rel=0.03)


@pytest.mark.long
def test_the_reference_and_what_is_in_no_loop_do_not_count():
    experiment = prepared("inverse3")
    from master.analysis.closed_loop.linearise import Linearisation

    assert in_loops(Linearisation(experiment).coupled()) == {
        "compensator",
        "spacecraft",
        "motion_simulator",
        "contact",
        "force_sensor",
    }


def test_the_default_box_is_about_contact_and_motion_simulator():
    experiment = prepare_to_run(E2)
    found = default_box(experiment.config)

    assert {name: (one.from_, one.to) for name, one in found.box.items()} == {
        "stiffness": (0.8, 1.2),
        "damping": (0.7, 1.3),
        "lag": (0.8, 1.2),
    }
    assert found.n_plants == 27
    own = own_values(found, experiment.system)
    assert dict(found.box["lag"].changes(1.25, own)) == {
        "motion_simulator.K_p": pytest.approx(24.0),
        "motion_simulator.w_v": pytest.approx(32.0 * math.pi),
    }


@pytest.mark.long
def test_every_fault_of_a_box_is_told(tmp_path):
    file = tmp_path / "box.yaml"
    file.write_text(
        "box:\n  k: {from: 1.2, to: 0.8, multiplies: [contact.k_m]}\n  c: {from: 0.5, to: 1}\npoints: 1\n"
    )
    with pytest.raises(ConfigError) as caught:
        read_box(file)
    assert len(caught.value.problems) == 3
    assert f"{file}:2" in str(caught.value)

    wrong = Box.model_validate(
        {
            "box": {
                "k": {"multiplies": ["contact.k"], "from": 0.8, "to": 1.2},
                "v": {"multiplies": ["force_sensor.offset"], "from": 0.8, "to": 1.2},
            }
        }
    )
    with pytest.raises(ConfigError) as caught:
        preflight(prepare_to_run(E2), wrong, "x")
    assert [p.where for p in caught.value.problems] == ["box.k", "box.v"]
    with pytest.raises(ConfigError, match=r"force_path: no such connected input, got 'contact.f'"):
        preflight(prepare_to_run(E2), box(force_path="contact.f"), "x")


def test_the_command_answers_with_status_json_and_a_page(tmp_path):
    def call(*more):
        options = ["--output", str(tmp_path), "--json", *more]
        answer = CliRunner().invoke(main, ["preflight", str(E2), *options])
        return answer.exit_code, json.loads(answer.stdout)

    file = tmp_path / "box.yaml"
    file.write_text(json.dumps(CORNER))
    exit_status, found = call("--box", str(file), "--methods", "robust")
    [one] = found["methods"]
    assert (exit_status, one["stable"], len(one["plants"])) == (0, True, 4)
    shown = f"{1e3 * one['latency']:.2f}"
    assert one["sentence"] == (
        f"stable for every plant in this box if the force path is known to +-{shown} ms"
    )
    page = (tmp_path / "preflight.html").read_text(encoding="utf-8")
    assert one["sentence"] in page.replace("&#43;", "+")
    assert "Least zeta over stiffness and lag" in page

    exit_status, found = call("--box", str(file), "--variant", "none")
    [one] = found["methods"]
    assert (exit_status, one["stable"], one["latency"]) == (4, False, None)
    assert one["sentence"].startswith("not stable for every plant in this box: 4 of 4 grow, the worst with")
    assert one["worst"]["zeta"] == min(p["zeta"] for p in one["plants"])
    assert np.isfinite(one["latency_closed_form"])
