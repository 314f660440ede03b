"""FMUs that crash, exit or spoil their process, in every command that calls them."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from master.cli import main
from master.process.child import done_apart
from master.recording.files import read_csv

from .build import FOLDERS, HERE, compile_c, write_fmu
from .foreign import COMPILED

pytestmark = COMPILED

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="ending" guid="ending">
  <CoSimulation modelIdentifier="ending" canGetAndSetFMUstate="true"/>
  <ModelVariables>
    <ScalarVariable name="y" valueReference="0" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="u" valueReference="1" causality="input"><Real start="0"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="1" dependencies=""/></Outputs></ModelStructure>
</fmiModelDescription>
"""
SYSTEM = """\
name: ending
step_size: 0.01
stop_time: 1.0
fmus: {{{name}: {{source: ending.fmu}}, other: {{source: ending.fmu}}}}
coupling: {{order: {order}}}
connections: [{{from: {name}.y, to: other.u}}, {{from: other.y, to: {name}.u, factor: -1.0}}]
"""
CASE = """\
name: ending
fmus: {exit_step: {source: ending.fmu}}
recordings: {a: run.csv}
time: {column: t}
signals: {u: {column: u}, y: {column: y}}
inputs: {exit_step.u: u}
compared: {exit_step.y: y}
split: {blocks: [fit, select, sealed], guard: 0.0}
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return compile_c("2.0", tmp_path_factory.mktemp("ending"), HERE / "spoiling2.c", "-lpthread")


@pytest.fixture
def command(library, tmp_path):
    """Run a command on a system in which an FMU ends its process as it is named."""
    write_fmu(tmp_path / "ending.fmu", DESCRIPTION, {f"{FOLDERS['2.0']}/ending.so": library})

    def run(command, name, *more, order=None):
        file = Path(os.path.relpath(tmp_path / "system.yaml"))
        file.write_text(SYSTEM.format(name=name, order=order or f"[{name}, other]"))
        return CliRunner().invoke(main, [command, str(file), *more])

    return run


ENDS = [
    ("exit_instantiate", "t=0 s: ended the process, exit status 0, in fmi2Instantiate"),
    ("crash_init", "t=0 s: ended the process, killed by SIGSEGV, in fmi2EnterInitializationMode"),
    ("exit_step", "t=0.09 s: ended the process, exit status 0, in fmi2DoStep"),
    ("crash_state", "t=10 s: ended the process, killed by SIGSEGV, in fmi2GetFMUstate"),
    ("exit_restore", "t=16.4 s: ended the process, exit status 0, in fmi2SetFMUstate"),
]


@pytest.mark.parametrize(("name", "said"), ENDS)
def test_an_analysis_names_the_fmu_that_ends_the_process_its_call_and_the_time(command, name, said):
    result = command("analyse", name, "--json")

    assert result.exit_code == 3
    assert json.loads(result.stdout) == {"status": "failed", "problems": [f"{name} at {said}"]}


@pytest.mark.parametrize(
    ("name", "function"), [("crash_state", "fmi2GetFMUstate"), ("exit_restore", "fmi2SetFMUstate")]
)
def test_a_run_that_iterates_names_the_call_for_the_state(command, tmp_path, name, function):
    order = f"[{{iterate: [{name}, other], tolerance: 1.0e-12}}]"
    result = command("run", name, "--output", str(tmp_path / "out"), order=order)

    assert result.exit_code == 3
    assert f"{name} at t=0 s: ended the process" in result.stderr
    assert f"in {function}" in result.stderr


def test_a_diagnosis_names_the_fmu_that_ends_the_process(command, tmp_path):
    (tmp_path / "run.csv").write_text(
        "t,u,y\n" + "".join(f"{0.1 * i:.1f},1,{0.1 * i:.1f}\n" for i in range(900))
    )
    (tmp_path / "case.yaml").write_text(CASE)
    result = CliRunner().invoke(
        main, ["diagnose", str(tmp_path / "case.yaml"), "--output", str(tmp_path / "d")]
    )

    assert result.exit_code == 3, result.stderr
    assert "exit_step at t=0.9 s: ended the process, exit status 0, in fmi2DoStep" in result.stderr


def test_a_crash_leaves_nothing_in_the_temporary_folder(command, tmp_path, monkeypatch):
    place = tmp_path / "temporary"
    place.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(place))
    command("analyse", "crash_step")

    assert list(place.iterdir()) == []


@pytest.mark.parametrize("name", ["chdir_instantiate", "chdir_init", "chdir_step", "chdir_free"])
@pytest.mark.parametrize("do", ["run", "analyse"])
def test_a_working_folder_that_an_fmu_changes_does_not_matter_to_relative_paths(
    command, tmp_path, monkeypatch, name, do
):
    monkeypatch.chdir(tmp_path)
    expected = command(do, "quiet", "--json")
    Path("system.yaml").unlink()
    result = command(do, name, "--json")

    assert result.exit_code == 0, result.stderr
    assert expected.exit_code == 0


def test_a_thread_that_an_fmu_leaves_behind_does_not_spoil_a_run(command, tmp_path):
    out = tmp_path / "out"
    result = command("run", "thread_step", "--output", str(out))

    assert result.exit_code == 0, result.stderr
    assert len(read_csv(out / "result.csv").time) == 101


def test_an_fmu_that_refuses_to_terminate_is_named_and_its_rows_stay(command, tmp_path):
    out = tmp_path / "out"
    result = command("run", "discard_terminate", "--json", "--output", str(out))
    [said] = json.loads(result.stdout)["messages"]

    assert result.exit_code == 0
    assert (said["fmu"], said["status"], said["t"]) == ("discard_terminate", "discard", 1.0)
    assert said["text"] == "fmi2Terminate answered with status discard: it cannot do this"
    assert len(read_csv(out / "result.csv").time) == 101


def test_what_work_prints_goes_to_standard_error_and_its_result_comes_back(capfd):
    def work():
        subprocess.run([sys.executable, "-c", "print('from an FMU')"], check=True)
        return {"answer": 42}

    assert done_apart(work) == {"answer": 42}
    printed = capfd.readouterr()
    assert (printed.out, printed.err) == ("", "from an FMU\n")


def test_an_error_of_the_work_is_raised_here():
    def work():
        raise KeyError("missing")

    with pytest.raises(KeyError, match="missing"):
        done_apart(work)
