"""What a comparison runs, and what it says of the runs."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

from master.api import prepare_to_run
from master.cli import main
from master.comparison.cells import Cell, read_cells
from master.comparison.compare import Score, Task, scores, tasks
from master.comparison.methods import all_methods, chosen
from master.comparison.page import shown, write_page
from master.comparison.systems import Base, system
from master.errors import ConfigError
from master.installation import CONFIG_FOLDER
from master.stepping.outcome import RunOptions
from master.stepping.simulate import simulate

E2 = CONFIG_FOLDER / "experiment_1000kg.yaml"
SHORT = {"stop_time": 0.5}


def made(cell=None, method="robust", seed=1):
    return system(Base(E2), Cell.model_validate(cell or {}), all_methods()[method], seed)


def parameters(document, instance):
    return document["fmus"][instance]["parameters"]


def test_a_method_takes_the_place_of_the_compensator_and_its_wires():
    document = made(seed=7)
    wires = {(w["from"], w["to"]) for w in document["connections"]}

    assert document["fmus"]["compensator"]["source"] == "robust"
    assert ("compensator.f_comp", "spacecraft.f") in wires
    assert ("spacecraft.v_des", "compensator.v_des") in wires
    assert not [w for w in wires if w[0] == "compensator.f_des"]
    assert document["compare"]["force"] == "compensator.f_comp"
    assert parameters(document, "spacecraft")["integrator"] == "leapfrog"
    assert parameters(document, "force_sensor")["seed"] == 7


def test_methods_are_told_the_configuration_without_the_changes_of_the_cell():
    cell = {"set": {"contact.k_p": 50_000.0, "force_sensor.T_f": 0.013}, "prior": {"k": 0.8, "c": 1.3}}
    document = made(cell)
    told = parameters(document, "compensator")

    assert (told["k_p"], told["c_m"], told["T_f_hat"], told["m_s"]) == pytest.approx(
        (0.8 * 37_760.0, 1.3 * 136.1, 0.01, 1000.0)
    )
    assert parameters(document, "contact")["k_p"] == 50_000.0
    assert parameters(document, "force_sensor")["T_f"] == 0.013


def test_stiffness_and_lag_are_those_of_the_whole():
    told = parameters(made(method="virtual_damper"), "compensator")

    assert told["stiffness"] == pytest.approx(139_200.0 * 37_760.0 / (139_200.0 + 37_760.0))
    assert told["latency"] == pytest.approx(1.0 / 30.0 + 0.002 + 0.0005 + 0.01)


def test_a_factor_is_of_the_configuration_or_of_the_default():
    cell = {
        "set": {
            "contact.k_p_amplitude": "0.2 contact.k_p",
            "motion_simulator.K_p": "1.25 motion_simulator.K_p",
        }
    }
    document = made(cell)

    assert parameters(document, "contact")["k_p_amplitude"] == pytest.approx(0.2 * 37_760.0)
    assert parameters(document, "motion_simulator")["K_p"] == pytest.approx(37.5)


@pytest.mark.parametrize(
    ("cell", "words"),
    [
        ({"set": {"contct.k_p": 1.0}}, "set.contct.k_p: no such instance, got 'contct'"),
        ({"set": {"contact.k_p": "two contact.k_p"}}, "set.contact.k_p: not a value, got 'two contact.k_p'"),
        ({"set": {"contact.k_p": "2 contact.k"}}, "set.contact.k_p: not a value, got '2 contact.k'"),
        ({"laws": {"contct": "docking_contact"}}, "laws.contct: no such instance"),
    ],
)
def test_a_cell_that_names_what_is_not_there_is_refused(cell, words):
    with pytest.raises(ConfigError) as error:
        made(cell)

    assert words in str(error.value)


def test_a_method_that_is_not_there_is_refused_by_name():
    with pytest.raises(ConfigError) as error:
        chosen("robust,robst")

    assert "--methods: no such method, got 'robst'" in str(error.value)


def test_preset_q_is_the_tuning_of_the_case_whose_stiffness_varies():
    base = Base(CONFIG_FOLDER / "time_varying_stiffness.yaml")
    values = all_methods()["paper_Q"].values
    numbers = {name: value for name, value in values.items() if isinstance(value, float)}

    assert base.document["fmus"][base.compensator]["parameters"]["preset"] == values["preset"] == "custom"
    assert set(numbers) == {"P0_ab", "P0_cde", "Q_ab", "Q_cde", "R", "prefilter_frequency"}
    assert {name: base.value(base.compensator, name) for name in numbers} == numbers


def test_a_configuration_without_a_compensator_is_refused(tmp_path):
    path = tmp_path / "alone.yaml"
    path.write_text(
        "name: alone\nstop_time: 1.0\nfmus: {mass: {source: spacecraft}}\ncoupling: {order: [mass]}\n"
    )
    with pytest.raises(ConfigError) as error:
        tasks([path], {"nominal": Cell()}, chosen("robust"), 1)

    assert "fmus: no instance of compensator" in str(error.value)


def test_the_shipped_cells_are_those_of_the_four_cases():
    cells = read_cells()
    configs = [CONFIG_FOLDER / f"{n}.yaml" for n in ("low_frequency", "high_frequency", "experiment")] + [E2]

    assert len(tasks(configs, cells, chosen("robust"), 1)) >= 50
    assert all(set(cell.configs or ()) <= {c.stem for c in configs} for cell in cells.values())


def test_the_score_is_the_worst_of_the_seeds_against_the_reference(tmp_path):
    """Computed again by hand, on runs of the system as a file."""
    cell = Cell.model_validate({**SHORT, "set": {"force_sensor.sigma": 5.0}})
    method = all_methods()["virtual_force"]
    errors = []
    for seed in (1, 2):
        path = tmp_path / f"{seed}.json"  # JSON is YAML
        path.with_suffix(".yaml").write_text(json.dumps(system(Base(E2), cell, method, seed)))
        experiment = prepare_to_run(path.with_suffix(".yaml"))
        result = simulate(
            experiment.system, experiment.schedule, experiment.grid, options=RunOptions()
        ).result
        ideal = result["ideal.s"]
        errors.append(
            [
                100.0 * np.linalg.norm(result[name] - ideal) / np.linalg.norm(ideal)
                for name in ("spacecraft.s_des", "motion_simulator.s_act")
            ]
        )
    [found] = scores([Task(E2, "noisy", cell, method, (1, 2))])

    assert (found.s_des, found.s_act) == pytest.approx(tuple(np.max(errors, axis=0)))
    assert errors[0] != errors[1]


def test_a_run_that_diverges_is_a_status_and_no_number():
    cell = Cell()
    task = Task(CONFIG_FOLDER / "high_frequency.yaml", "nominal", cell, all_methods()["cr_inverse"], (1,))
    [found] = scores([task])

    assert (found.status, found.s_des, found.s_act, shown(found)) == ("diverged", None, None, "diverged")


def test_fmus_that_stay_loaded_change_no_score():
    """Cells with other seeds, values, wires and models, one after the other, and each alone in new FMUs."""
    cells = {
        "jitter": {**SHORT, "events": [{"at": 0, "jitter": {"compensator.f_mea": 2}}]},
        "noise": {**SHORT, "s_act_noise": 2e-5, "set": {"force_sensor.sigma": 5.0}},
        "rope": {
            **SHORT,
            "laws": {"contact": "docking_contact__rope_force_slack"},
            "set": {"contact.rope_force_slack_limit": 0.001},
        },
        "believed": {**SHORT, "prior": {"k": 0.8}},
    }
    method = all_methods()["robust"]
    work = [Task(E2, name, Cell.model_validate(cell), method, (1, 2)) for name, cell in cells.items()]

    alone = [scores([task])[0] for task in work]

    assert scores([*work, *work]) == [*alone, *alone]
    assert len({score.s_des for score in alone}) == len(cells)


def test_the_command_prints_one_object_and_writes_the_page(tmp_path):
    cells = tmp_path / "cells.yaml"
    cells.write_text("cells: {short: {stop_time: 0.5}, noisy: {stop_time: 0.5, s_act_noise: 2e-5}}\n")
    arguments = ["compare-methods", "experiment_1000kg", "--methods", "robust,inverse3", "--cells", cells]
    arguments += ["--seeds", 1, "--processes", 1, "--json", "--output", tmp_path]
    done = CliRunner().invoke(main, list(map(str, arguments)))
    found = json.loads(done.stdout)["cells"]

    assert [(c["config"], c["cell"], c["method"]) for c in found] == [
        ("experiment_1000kg", cell, method)
        for cell in ("short", "noisy")
        for method in ("robust", "inverse3")
    ]
    assert all(c["status"] == "completed" and 0.0 < c["s_des"] < 5.0 for c in found)
    assert "inverse3" in (tmp_path / "comparison.html").read_text()


def test_the_page_escapes_names_and_shades_by_the_error(tmp_path):
    scores = [
        Score("a", "<b>", "good", 0.05, 0.1, "completed"),
        Score("a", "<b>", "bad", None, None, "diverged"),
    ]
    write_page(scores, 2, tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text()

    assert "&lt;b&gt;" in text
    assert '<td class="s0">0.05/0.10</td><td class="s5">diverged</td>' in text
