"""A run repeated from its folder: the same bits, or what differs."""

from __future__ import annotations

import json
import shutil
import zipfile
from hashlib import sha256
from pathlib import Path

import pytest
from click.testing import CliRunner

from master.cli import main
from master.runs import manifest as manifests

FMUS = Path(__file__).parents[3] / "fmus"
TEXT = """\
name: test
step_size: 0.5
stop_time: 20.0
fmus:
  mass: {source: spacecraft.fmu, parameters: {m_s: 2.0}, start: {v_des: 1.0}}
  sensor: {source: force_sensor.fmu, parameters: {seed: 4}}
coupling: {order: [mass, sensor]}
connections:
  - {from: sensor.f_mea, to: mass.f}
variants:
  heavy: {mass: {m_s: 5}}
"""
JITTER = "events: [{at: 1.0, jitter: {mass.f: 3}, seed: 7}]\n"


def call(*words):
    done = CliRunner().invoke(main, [*map(str, words)])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done


@pytest.fixture
def folder(tmp_path):
    """A folder with two FMUs of the project."""
    for name in ("spacecraft.fmu", "force_sensor.fmu"):
        shutil.copy(FMUS / name, tmp_path)
    return tmp_path


def system(folder, text=TEXT):
    path = folder / "system.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture
def ran(folder):
    """Run a text with options; return the results folder."""

    def run(text=TEXT, *options):
        out = folder / "out"
        call("run", system(folder, text), "--output", out, *options)
        return out

    return run


def with_another_start(file, old, new):
    """Replace a text in the description of an FMU."""
    with zipfile.ZipFile(file) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    assert old in content["modelDescription.xml"]
    content["modelDescription.xml"] = content["modelDescription.xml"].replace(old, new)
    with zipfile.ZipFile(file, "w") as archive:
        for name, data in content.items():
            archive.writestr(name, data)


def manifest_of(out):
    return json.loads((out / "manifest.json").read_text(encoding="utf-8"))


def test_the_manifest_says_what_a_run_was_made_of(ran, folder):
    out = ran(TEXT + JITTER, "--variant", "heavy", "--set", "mass.m_s=3", "--stop-time", "2")
    found = manifest_of(out)
    file = folder / "system.yaml"

    assert found["command"] == [
        *("dockloop", "run", str(file), "--variant", "heavy"),
        *("--set", "mass.m_s=3", "--stop-time", "2.0"),
    ]
    assert found["configuration"]["sha256"] == sha256(file.read_bytes()).hexdigest()
    assert found["fmus"]["mass"]["sha256"] == sha256((folder / "spacecraft.fmu").read_bytes()).hexdigest()
    assert found["fmus"]["mass"]["source"] == "spacecraft.fmu"
    assert found["seeds"] == {"sensor.seed": 4, "events[0]": 7}
    assert (found["status"], found["steps"]) == ("completed", 4)
    assert {"platform", "python", "numpy"} <= set(found["machine"])
    assert found["dockloop"]["version"]
    assert found["duration"] > 0.0
    for name in ("result.csv", "result.parquet"):
        assert found["results"][name] == sha256((out / name).read_bytes()).hexdigest()


def test_the_report_names_the_manifest(folder):
    out = folder / "out"
    done = call("run", system(folder), "--output", out, "--json")

    assert json.loads(done.stdout)["files"]["manifest"] == str(out / "manifest.json")


@pytest.mark.parametrize(
    ("text", "options"),
    [
        (TEXT, ()),
        (TEXT + JITTER, ("--variant", "heavy", "--set", "mass.m_s=3")),
        (TEXT + "limits: {mass.s_des: 5}\n", ()),
        (TEXT + "record: {signals: mass.s_des, every: 3}\n", ("--step-size", "0.25")),
    ],
)
def test_a_repeated_run_has_the_same_bits(ran, text, options):
    out = ran(text, *options)
    done = call("rerun", out, "--json")

    assert (done.exit_code, json.loads(done.stdout)["differences"]) == (0, [])
    assert call("rerun", out).stdout.startswith(f"{out}: same bits in ")


def test_a_configuration_that_changed_is_named_with_the_signals_that_it_changes(ran, folder):
    out = ran()
    system(folder, TEXT.replace("m_s: 2.0", "m_s: 3.0"))
    done = call("rerun", out)

    assert done.exit_code == 1
    assert "configuration: has changed" in done.stdout
    assert "mass.s_des: differs by up to " in done.stdout
    assert "same bits" not in done.stdout


def test_an_fmu_that_changed_is_named_even_if_the_bits_are_the_same(ran, folder):
    out = ran()
    with_another_start(folder / "spacecraft.fmu", b'"820.0"', b'"821.0"')  # the file sets another mass
    done = call("rerun", out)

    assert done.exit_code == 1
    [_, line] = done.stdout.splitlines()
    assert line.startswith("  fmus.mass: has changed")


def test_a_recording_that_changed_is_named(ran, folder):
    file = folder / "push.csv"
    file.write_text("t,F\n0,1\n30,1\n", encoding="utf-8")
    push = "inputs: {file: push.csv, time: {column: t, unit: s}, map: {sensor.f_act: {column: F, unit: N}}}\n"
    out = ran(TEXT + push)
    assert call("rerun", out).exit_code == 0
    assert manifest_of(out)["inputs"]["push.csv"]["sha256"] == sha256(file.read_bytes()).hexdigest()
    file.write_text("t,F\n0,2\n30,2\n", encoding="utf-8")
    done = call("rerun", out)

    assert done.exit_code == 1
    assert "inputs.push.csv: has changed" in done.stdout
    assert "mass.s_des: differs by up to " in done.stdout


def test_results_that_were_changed_after_the_run_are_not_the_same(ran):
    out = ran()
    (out / "result.csv").write_text("time,mass.s_des\n0,1\n", encoding="utf-8")
    done = call("rerun", out)

    assert done.exit_code == 1
    assert "result.csv: is not what the run wrote" in done.stdout


def test_a_run_that_ended_elsewhere_is_not_the_same(ran):
    out = ran()
    content = manifest_of(out) | {"steps": 39}
    (out / "manifest.json").write_text(json.dumps(content), encoding="utf-8")
    done = call("rerun", out)

    assert done.exit_code == 1
    assert "end: got completed after 40 steps, expected completed after 39 steps" in done.stdout


def test_another_version_is_a_note(ran, monkeypatch):
    out = ran()
    monkeypatch.setattr(manifests, "_program", lambda: {"version": "9.9"})
    done = call("rerun", out)

    assert done.exit_code == 0
    assert "note: version: got 9.9, in the first run " in done.stdout


def test_the_results_of_the_second_run_are_kept_where_they_are_asked_for(ran, folder):
    out = ran()
    done = call("rerun", out, "--output", folder / "again")

    assert done.exit_code == 0
    assert call("compare", out, folder / "again").exit_code == 0
    refused = call("rerun", out, "--output", out)
    assert (refused.exit_code, "would replace what is compared" in refused.stderr) == (2, True)
    assert (out / "result.csv").is_file()


@pytest.mark.parametrize("content", [None, "{", '{"format": 2}', '{"format": 1}'])
def test_a_folder_without_a_whole_manifest_has_status_2(tmp_path, content):
    if content is not None:
        (tmp_path / "manifest.json").write_text(content, encoding="utf-8")

    assert call("rerun", tmp_path).exit_code == 2


def test_a_configuration_that_is_gone_has_status_2(ran, folder):
    out = ran()
    (folder / "system.yaml").unlink()
    done = call("rerun", out)

    assert done.exit_code == 2
    assert "system.yaml" in done.stderr


def test_a_run_that_cannot_begin_leaves_a_manifest(folder):
    out = folder / "out"
    done = call("run", system(folder, TEXT.replace("seed: 4", "seed: 4, sample_time: 0")), "--output", out)

    assert done.exit_code == 3
    assert (manifest_of(out)["status"], manifest_of(out)["results"]) == ("failed", {})


def test_a_table_of_the_command_drives_the_second_run_too(folder, ran, monkeypatch):
    """`--inputs` with a relative path, repeated from another folder; then with another table."""
    table = folder / "force.csv"
    table.write_text("time,sensor.f_act\n0,1\n10,2\n20,3\n", encoding="utf-8")
    monkeypatch.chdir(folder)
    out = ran(TEXT, "--inputs", "force.csv")
    monkeypatch.chdir("/")

    assert call("rerun", out).exit_code == 0

    table.write_text("time,sensor.f_act\n0,1\n10,2\n20,4\n", encoding="utf-8")
    done = call("rerun", out)

    assert done.exit_code == 1
    assert "force.csv" in done.output
