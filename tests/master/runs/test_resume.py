"""`run --checkpoint` and `resume`: killed, gone on, and refused where it would not be the same run."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from click.testing import CliRunner

from master.cli import main
from master.recording.checkpoints import read_checkpoint

PROJECT = Path(__file__).parents[3]
FMUS = PROJECT / "fmus"
TEXT = """\
name: test
step_size: 0.001
stop_time: 3000.0
fmus:
  mass: {source: spacecraft.fmu, parameters: {m_s: 2.0}, start: {v_des: 1.0}}
  sensor: {source: force_sensor.fmu, parameters: {seed: 4, sigma: 0.2}}
coupling: {order: [mass, sensor]}
connections:
  - {from: sensor.f_mea, to: mass.f, delay: 2}
record: {signals: [mass.s_des, sensor.f_mea], every: 50}
"""

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="runs have no process there")


def call(*words):
    done = CliRunner().invoke(main, [*map(str, words)])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done


def write_system(tmp_path):
    for name in ("spacecraft.fmu", "force_sensor.fmu"):
        shutil.copy(FMUS / name, tmp_path)
    path = tmp_path / "system.yaml"
    path.write_text(TEXT, encoding="utf-8")
    return path


@pytest.fixture
def file(tmp_path):
    return write_system(tmp_path)


def killed_amid(file, out, number=signal.SIGKILL):
    """Begin a run with checkpoints and end it when one amid the run is there."""
    words = [sys.executable, "-m", "master", "run", str(file), "--output", str(out), "--checkpoint", "20ms"]
    environment = os.environ | {"PYTHONPATH": str(PROJECT)}
    process = subprocess.Popen(words, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while process.poll() is None:
        if (out / "checkpoint").exists() and read_checkpoint(out).mark.n_rows > 1:
            process.send_signal(number)
            break
        time.sleep(0.005)
    process.wait(timeout=60.0)
    return out


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    """A run that was killed, for tests that look at it."""
    folder = tmp_path_factory.mktemp("killed")
    return killed_amid(write_system(folder), folder / "out")


@pytest.fixture
def killed(once, tmp_path):
    """A copy of its results; what it was made of is shared, and put back."""
    sources = {path: path.read_bytes() for path in once.parent.iterdir() if path.is_file()}
    yield Path(shutil.copytree(once, tmp_path / "killed"))
    for path, content in sources.items():
        path.write_bytes(content)


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, pytest.param(signal.SIGTERM, marks=pytest.mark.long)])
def test_a_run_that_was_ended_goes_on_with_the_same_bits(file, number):
    out = killed_amid(file, file.parent / "out", number)
    status = json.loads((out / "manifest.json").read_text())["status"]
    assert status == ("running" if number == signal.SIGKILL else "interrupted")
    tick = read_checkpoint(out).mark.n_rows - 1
    done = call("resume", out, "--json")
    whole = file.parent / "whole"
    call("run", file, "--output", whole)

    assert done.exit_code == 0
    assert f"went on after {tick} steps" in done.stderr
    assert 0 < tick < 3_000_000
    assert json.loads(done.stdout)["steps"] == 3_000_000
    assert (out / "result.csv").read_bytes() == (whole / "result.csv").read_bytes()
    assert (out / "result.parquet").read_bytes() == (whole / "result.parquet").read_bytes()
    manifest = json.loads((out / "manifest.json").read_text())
    assert [one["tick"] for one in manifest["resumed"]] == [tick]
    assert manifest["status"] == "completed"
    assert not list(out.glob("checkpoint*"))
    again = call("resume", out)
    assert (again.exit_code, again.stdout) == (2, "")
    assert "the run has come to its end, got completed" in again.stderr


def test_what_changed_since_is_refused_by_name(killed, once):
    file = once.parent / "system.yaml"
    before = {path.name: path.read_bytes() for path in killed.iterdir()}
    file.write_text(TEXT.replace("m_s: 2.0", "m_s: 3.0"), encoding="utf-8")
    shutil.copy(FMUS / "fmi3" / "spacecraft.fmu", file.parent)
    done = call("resume", killed)

    assert done.exit_code == 2
    [configuration, fmu] = done.stderr.splitlines()
    assert configuration.startswith(f"configuration: has changed ({file}), got sha256 ")
    assert fmu.startswith("fmus.mass: has changed")
    assert {path.name: path.read_bytes() for path in killed.iterdir()} == before


def test_a_damaged_checkpoint_is_refused(killed):
    path = killed / "checkpoint"
    data = bytearray(path.read_bytes())
    data[-200] ^= 1
    path.write_bytes(data)
    done = call("resume", killed)

    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert "is damaged" in done.stderr


def test_results_that_are_shorter_than_the_checkpoint_says_are_refused(killed):
    (killed / "result.csv").write_text("time\n")
    done = call("resume", killed)

    assert done.exit_code == 2
    assert "result.csv: is too short, got 5 bytes, expected " in done.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--checkpoint", "0s"], "not a time between checkpoints, got '0s', expected a time from 10 ms"),
        (["--checkpoint", "1 week"], "not a time between checkpoints, got '1 week'"),
        (["--priority", "80"], "--priority: not in real time, got no --real-time, expected both"),
        (["--core", "0"], "--core: not in real time, got no --real-time, expected both"),
        (["--checkpoint", "60s", "--real-time"], "--checkpoint: in real time, got --real-time"),
    ],
)
def test_a_wrong_option_is_refused_before_the_run(file, words, said):
    done = call("run", file, "--output", file.parent / "out", *words)

    assert done.exit_code == 2
    assert said in done.stderr
    assert not (file.parent / "out").exists()


def test_an_fmu_that_cannot_write_its_state_is_refused_before_the_run(file):
    import zipfile

    fmu = file.parent / "force_sensor.fmu"
    with zipfile.ZipFile(fmu) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    text = content["modelDescription.xml"].replace(b'canSerializeFMUstate="true"', b"")
    assert text != content["modelDescription.xml"]
    with zipfile.ZipFile(fmu, "w") as archive:
        for name, data in content.items():
            archive.writestr(name, text if name == "modelDescription.xml" else data)
    done = call("run", file, "--output", file.parent / "out", "--checkpoint", "60s")

    assert done.exit_code == 2
    assert done.stderr.startswith("--checkpoint: sensor: cannot write its state to a file")
    assert not (file.parent / "out").exists()


def test_a_folder_without_checkpoints_is_no_run_to_go_on_with(file):
    out = file.parent / "out"
    call("run", file, "--stop-time", "0.1", "--output", out)

    assert call("resume", out).exit_code == 2
    assert "a run without checkpoints" in call("resume", out).stderr
    assert "no manifest.json" in call("resume", file.parent / "nowhere").stderr
