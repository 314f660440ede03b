"""FMUs that do to their process what they should not: the run ends with what there is, and names them."""

import ctypes
import json
import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from click.testing import CliRunner

from master.cli import main
from master.recording.files import read_csv
from tests.stubs import calling

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the run is not forked here")

TEXT = """\
name: test
step_size: 0.5
stop_time: {stop}
fmus: {{clock: {{source: clock.fmu}}, bad: {{source: bad.fmu}}}}
"""


@pytest.fixture
def run(bay):
    """Run a system in which an FMU does something at a time; returns the result, the summary and the rows."""

    def call(deed, at=10.0, *, stop=20.0, options=()):
        bay.made["bad"] = calling(lambda t: deed() if t == at else None)
        (bay.folder / "bad.fmu").touch()
        path = bay.write(TEXT.format(stop=stop))
        out = bay.folder / "out"
        result = CliRunner().invoke(main, ["run", str(path), "--json", "--output", str(out), *options])
        assert isinstance(result.exception, SystemExit | None), result.exception
        summary = json.loads((out / "summary.json").read_text())
        return result, summary, read_csv(out / "result.csv")

    return call


def kill(number):
    return lambda: os.kill(os.getpid(), number)


ENDS = [
    (lambda: os._exit(0), "ended the process, exit status 0"),
    (lambda: ctypes.CDLL(None).exit(3), "ended the process, exit status 3"),
    (kill(signal.SIGSEGV), "ended the process, killed by SIGSEGV"),
    (kill(signal.SIGKILL), "ended the process, killed by SIGKILL"),
    (kill(signal.SIGFPE), "ended the process, killed by SIGFPE"),
    (lambda: ctypes.CDLL(None).abort(), "ended the process, killed by SIGABRT"),
]


@pytest.mark.parametrize(("deed", "said"), ENDS)
@pytest.mark.parametrize("stop", [20.0, 1e5])
def test_an_fmu_that_ends_the_process_is_named_and_its_rows_stay(run, deed, said, stop):
    result, summary, rows = run(deed, stop=stop)

    assert (result.exit_code, summary["status"], summary["steps"]) == (3, "failed", 20)
    assert summary["message"] == f"bad at t=10 s: {said}, in fmi2DoStep"
    assert np.array_equal(rows["clock.t"], 0.5 * np.arange(21))
    assert json.loads(result.stdout) == summary


def write_to_standard_output():
    sys.stdout.write("from Python")
    os.write(1, b"from a descriptor\n")
    ctypes.CDLL(None).puts(b"from C")


def close_descriptors():
    os.closerange(3, 200)


CHANGES = [
    write_to_standard_output,
    close_descriptors,
    lambda: os.chdir("/"),
    lambda: os.umask(0o777),
    lambda: signal.signal(signal.SIGINT, signal.SIG_IGN),
    lambda: (os.close(1), os.close(2)),
    lambda: ctypes.CDLL(None).fork(),
    lambda: subprocess.run(["true"], check=True),
]


@pytest.mark.parametrize("deed", CHANGES)
def test_what_an_fmu_does_to_its_process_changes_nothing(run, deed):
    folder, umask = os.getcwd(), os.umask(0o022)
    result, summary, rows = run(deed)

    assert (result.exit_code, summary["status"], len(rows.time)) == (0, "completed", 41)
    assert json.loads(result.stdout) == summary
    assert os.stat(summary["files"]["csv"]).st_mode & 0o777 == 0o644
    assert (os.getcwd(), os.umask(umask)) == (folder, 0o022)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize("stop", [2e4, 1e5])
def test_a_signal_in_a_run_ends_it_with_what_there_is(run, number, stop):
    result, summary, rows = run(lambda: os.kill(os.getppid(), number), stop=stop)

    assert (result.exit_code, summary["status"]) == (128 + number, "interrupted")
    assert 20 <= summary["steps"] == len(rows.time) - 1 < 2 * stop
    assert json.loads(result.stdout) == summary


def insist():
    """Hang; a user presses Ctrl-C, and a second later again."""
    import time

    for _ in range(2):
        os.kill(os.getppid(), signal.SIGINT)
        time.sleep(1.0)
    time.sleep(600.0)


def test_the_second_ctrl_c_ends_an_fmu_that_hangs(run):
    result, summary, rows = run(insist)

    assert (result.exit_code, summary["status"], len(rows.time)) == (130, "interrupted", 21)
    assert summary["message"] == "interrupted: bad at t=10 s: did not return from fmi2DoStep"


def test_a_folder_removed_in_a_run_holds_its_rows_in_the_end(run, bay):
    import shutil

    result, summary, rows = run(lambda: shutil.rmtree(bay.folder / "out"))

    assert (result.exit_code, summary["status"]) == (3, "failed")
    assert "removed during the run" in summary["message"]
    assert len(rows.time) == 41


def test_a_picture_that_cannot_be_drawn_is_a_note(run, monkeypatch):
    from master.evaluation import report

    def fail(*_):
        raise ValueError("Unknown symbol: \\oops")

    monkeypatch.setattr(report, "plot_run", fail)
    monkeypatch.setitem(globals(), "TEXT", TEXT + "compare: {{signal: clock.t, offset: 1.0}}\n")
    result, summary, _ = run(lambda: None, stop=20.0)

    assert (result.exit_code, summary["status"]) == (0, "completed")
    assert summary["notes"] == ["plots.png cannot be drawn: Unknown symbol: \\oops"]
    assert "plot" not in summary["files"]


def test_nothing_is_left_in_the_temporary_folder(run, tmp_path, monkeypatch):
    import tempfile

    place = tmp_path / "temporary"
    place.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(place))
    run(lambda: os._exit(0))

    assert list(place.iterdir()) == []
