"""Systems from Python: what is loaded, run, swept and written is what the command would."""

from __future__ import annotations

import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import dockloop as dl
from tests.dockloop.conftest import semi_implicit, spring

PROJECT = Path(__file__).parents[2]


def test_a_run_has_the_rows_of_the_command(tmp_path):
    options = ["--variant", "none", "--stop-time", "0.5", "--set", "spacecraft.m_s=500"]
    command = [sys.executable, "-m", "master", "run", "low_frequency", *options, "--output", str(tmp_path)]
    subprocess.run(command, cwd=PROJECT, check=True, capture_output=True)
    run = dl.load("low_frequency").run(variant="none", set={"spacecraft.m_s": 500}, stop_time=0.5)
    files = run.save(tmp_path / "own")

    assert files["csv"].read_bytes() == (tmp_path / "result.csv").read_bytes()
    assert files["parquet"].is_file()


def test_a_block_next_to_an_fmu_gives_the_exact_oscillator(sprung):
    run = sprung.run()

    assert run.status == "completed"
    assert run["mass.s_des"].tolist() == semi_implicit(500)
    assert run.unit("spring.f") == "N"


def test_a_parameter_of_a_block_is_set_like_that_of_an_fmu(sprung):
    assert sprung.run(set={"spring.k": 50})["mass.s_des"].tolist() == semi_implicit(500, k=50.0)
    assert sprung.run()["mass.s_des"].tolist() == semi_implicit(500)


def test_a_recording_drives_a_free_input_and_is_read_for_each_run(tmp_path):
    mass = {"source": "spacecraft", "parameters": {"m_s": 2.0}}
    system = dl.load({"name": "pushed", "step_size": 0.01, "stop_time": 1.0, "fmus": {"mass": mass}})
    push = tmp_path / "push.csv"
    for force in (4.0, 8.0):
        push.write_text(f"t,mass.f\n0,{force}\n1,{force}\n", encoding="utf-8")
        run = system.run(inputs=push)

        assert run["mass.v_des"] == pytest.approx(force / 2.0 * run.time, rel=1e-12)


def test_a_block_takes_the_place_of_an_fmu_of_a_file(tmp_path):
    text = """\
name: file
stop_time: 0.5
fmus:
  mass: {source: spacecraft, parameters: {m_s: 1}, start: {s_des: 1}}
  spring: {source: not_there_yet}
coupling: {order: [spring, mass]}
connections: [{from: mass.s_des, to: spring.x}, {from: spring.f, to: mass.f}]
"""
    (tmp_path / "file.yaml").write_text(text, encoding="utf-8")
    system = dl.load(tmp_path / "file.yaml", blocks={"spring": spring()})

    assert system.run()["mass.s_des"].tolist() == semi_implicit(500)


def test_a_sweep_converts_units_and_takes_every_combination(sprung):
    values = {"spring.k": [0.05, 0.1], "mass.m_s": np.array([1.0, 2.0])}
    runs = list(sprung.sweep(values, unit={"spring.k": "N/mm"}, stop_time=0.01))

    assert [(r.values["spring.k"], r.values["mass.m_s"]) for r in runs] == [
        (50.0, 1.0), (50.0, 2.0), (100.0, 1.0), (100.0, 2.0),
    ]  # fmt: skip
    assert runs[2]["mass.s_des"].tolist() == semi_implicit(10)


def test_a_sweep_says_all_faults_before_the_first_run(sprung):
    with pytest.raises(dl.ConfigError) as error:
        sprung.sweep({"mass.m_s": [1.0, -1.0, "heavy"]})

    assert [(p.where, p.got) for p in error.value.problems] == [
        ("set mass.m_s", "-1.0 kg"),
        ("set mass.m_s", "'heavy' kg"),
    ]


def test_all_faults_of_a_request_are_in_the_exception(sprung):
    with pytest.raises(dl.ConfigError) as error:
        sprung.run("none", set={"mass.m": 1, "sprig.k": 2})

    assert [p.where for p in error.value.problems] == ["variant", "set mass.m", "set sprig.k"]


def test_a_unit_of_another_quantity_is_refused(sprung):
    with pytest.raises(dl.ConfigError, match=r"unit spring\.k: another quantity, got s, expected one as N/m"):
        sprung.run(set={"spring.k": 1.0}, unit={"spring.k": "s"})


def test_all_faults_of_a_dict_are_said_by_their_keys():
    with pytest.raises(dl.ConfigError) as error:
        dl.load({"name": "x", "stop_time": -1, "fmus": {"a": {"source": "no_such_model"}}, "colour": "red"})

    text = str(error.value)
    assert "no_such_model" in text
    assert "stop_time" in text
    assert "colour" in text


def test_an_unknown_name_is_told_what_is_near():
    with pytest.raises(dl.ConfigError, match="as low_frequency"):
        dl.load("low_frequenzy")


def test_what_a_failing_block_says_ends_the_run_with_its_line_and_the_rows_before(sprung):
    def step(t, h, values):
        return {"f": 1.0 / (0.0 if t > 0.0095 else 1.0)}

    system = dl.load({"name": "x", "stop_time": 0.1, "fmus": {"b": dl.block((), {"f": "N"}, step)}})
    with pytest.raises(
        dl.FmuError, match=r"b at t=0\.01 s: ZeroDivisionError: .*\(test_system\.py:\d+\)"
    ) as error:
        system.run()

    assert len(error.value.run) == 11


def test_a_system_with_a_block_is_not_written_as_ssp(sprung, tmp_path):
    with pytest.raises(dl.ConfigError, match="spring: an SSP needs FMU files, got a Python block"):
        dl.write_ssp(sprung, tmp_path / "x.ssp")


def test_a_written_ssp_runs_with_the_same_rows(tmp_path):
    system = dl.load("low_frequency")
    back = dl.load(dl.write_ssp(system, tmp_path / "x.ssp"))

    assert back.run(stop_time=0.2)["spacecraft.s_des"].tolist() == (
        system.run(stop_time=0.2)["spacecraft.s_des"].tolist()
    )


def test_analysis_finds_the_damping_of_the_run():
    run = dl.load("low_frequency").run(variant="dpdc")
    found = dl.analyse("low_frequency", "dpdc")

    assert found.dominant.zeta == pytest.approx(run.metrics["zeta"], rel=0.02)


def test_progress_ends_at_one_and_nothing_is_printed(sprung, capfd):
    shares = []
    sprung.run(progress=shares.append)

    assert shares[-1] == 1.0
    assert shares == sorted(shares)
    assert capfd.readouterr() == ("", "")


def test_two_systems_run_in_two_threads(sprung):
    other = dl.load({"name": "o", "stop_time": 0.5, "fmus": {"s": {"source": "spacecraft"}}})
    found = {}
    threads = [
        threading.Thread(target=lambda: found.update(a=sprung.run())),
        threading.Thread(target=lambda: found.update(b=other.run(set={"s.f": 820.0}))),
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()

    assert found["a"]["mass.s_des"].tolist() == semi_implicit(500)
    assert found["b"]["s.v_des"][-1] == pytest.approx(0.5, rel=1e-12)


def test_every_public_name_has_a_docstring_and_is_loaded_when_it_is_used():
    assert all(getattr(dl, name).__doc__ for name in dl.__all__)
    with pytest.raises(AttributeError, match="no attribute 'lode'"):
        dl.lode  # noqa: B018
    code = (
        "import sys, dockloop; print(sorted({'numpy', 'numba', 'matplotlib', 'pandas'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=PROJECT, check=True
    )
    assert done.stdout == "[]\n"
