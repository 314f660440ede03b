"""A signal at any moment: the exit status is its own, files are readable, and nothing is left behind."""

import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from pyarrow import parquet

from master.recording.files import read_csv

PROJECT = Path(__file__).parents[3]
EXPERIMENT = PROJECT / "configs" / "experiment.yaml"
CASE = PROJECT / "configs" / "measured" / "docking_rig.yaml"
N_MOMENTS = int(os.environ.get("DOCKLOOP_SIGNALS", "4"))
SIGNALS = [signal.SIGTERM, signal.SIGHUP, signal.SIGINT]
RUNS = {
    "in memory": ["--stop-time", "5"],
    "streamed": ["--stop-time", "110"],
    "first compilation": ["--stop-time", "5"],
    "closed pipe": ["--stop-time", "110", "--json"],
}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="signals of this kind are not here"),
]


class Command:
    """The command in a process group of its own, with a temporary folder of its own."""

    def __init__(self, folder, arguments, **options):
        self.temporary = folder / "temporary"
        self.temporary.mkdir()
        self.errors = folder / "stderr"
        environment = os.environ | {"TMPDIR": str(self.temporary), "PYTHONPATH": str(PROJECT)}
        environment |= options.pop("environment", {})
        with self.errors.open("wb") as errors:
            self.process = subprocess.Popen(
                [*options.pop("through", ()), sys.executable, "-m", "master", *map(str, arguments)],
                cwd=folder,
                env=environment,
                stdout=options.pop("stdout", subprocess.DEVNULL),
                stderr=errors,
                start_new_session=True,
                preexec_fn=options.pop("preexec_fn", None),
            )

    def wait_for_handlers(self):
        """Wait until the process takes signals, as its first lines let it."""
        caught = 1 << signal.SIGHUP - 1
        while self.process.poll() is None:
            status = Path(f"/proc/{self.process.pid}/status").read_text()
            if int(status.partition("SigCgt:")[2].split()[0], 16) & caught:
                return
            time.sleep(0.002)

    def end(self, number):
        """Send a signal to all of its processes, as a terminal does; return the exit status."""
        if self.process.poll() is None:
            os.killpg(self.process.pid, number)
        return self.process.wait(timeout=60.0)


def lasts(folder, arguments):
    """Time that the command takes undisturbed [s]."""
    folder.mkdir()
    begin = time.monotonic()
    assert Command(folder, arguments).process.wait() == 0
    return time.monotonic() - begin


@pytest.fixture(scope="module")
def durations(tmp_path_factory):
    """Seconds that each kind of run takes here; the first one builds and compiles what is missing."""
    folder = tmp_path_factory.mktemp("durations")
    lasts(folder / "build", ["run", EXPERIMENT])
    memory = lasts(folder / "memory", ["run", EXPERIMENT, *RUNS["in memory"]])
    streamed = lasts(folder / "streamed", ["run", EXPERIMENT, *RUNS["streamed"]])
    return {
        "in memory": memory,
        "streamed": streamed,
        "first compilation": 2.0 * memory,
        "closed pipe": streamed,
    }


@pytest.mark.parametrize("i", range(N_MOMENTS))
def test_a_signal_at_a_random_moment_leaves_readable_files_and_a_true_summary(i, durations, tmp_path):
    draw = random.Random(i)
    number = SIGNALS[i % len(SIGNALS)]  # each with each kind in twelve moments
    kind = list(RUNS)[i % len(RUNS)]
    options = {}
    if kind == "first compilation":
        options["environment"] = {"NUMBA_CACHE_DIR": str(tmp_path / "numba")}
    if kind == "closed pipe":
        reading, options["stdout"] = os.pipe()
        os.close(reading)
    command = Command(tmp_path, ["run", EXPERIMENT, *RUNS[kind], "--output", tmp_path / "out"], **options)
    if kind == "closed pipe":
        os.close(options["stdout"])
    begin = time.monotonic()
    command.wait_for_handlers()
    time.sleep(max(0.0, draw.uniform(0.0, durations[kind]) - (time.monotonic() - begin)))
    status = command.end(number)

    said = command.errors.read_text()
    assert "Traceback" not in said, said
    assert list(command.temporary.iterdir()) == []
    summary = tmp_path / "out" / "summary.json"
    if not summary.exists():
        assert status == 128 + number
        assert not (tmp_path / "out").exists()
        return
    report = json.loads(summary.read_text())
    if "csv" not in report["files"]:  # of a streamed run that was still loading
        assert (report["status"], report["steps"], status) == ("interrupted", 0, 128 + number)
        assert sorted(f.name for f in (tmp_path / "out").iterdir()) == ["manifest.json", "summary.json"]
        return
    rows = read_csv(tmp_path / "out" / "result.csv")
    assert len(rows.time) == report["steps"] + 1 or (report["steps"] == 0 and not len(rows.time))
    assert parquet.read_table(tmp_path / "out" / "result.parquet").num_rows == len(rows.time)
    wanted = round(float(RUNS[kind][1]) / 0.001)
    if report["status"] == "completed":
        assert report["steps"] == wanted
        assert status in (0, 128 + number, -number)
    else:
        assert (report["status"], status) == ("interrupted", 128 + number)
        assert report["steps"] <= wanted
    assert not list((tmp_path / "out").glob(".*"))


COMMANDS = {  # and the seconds in which it is at work for certain
    ("check", EXPERIMENT): 0.1,
    ("explain", EXPERIMENT): 0.1,
    ("analyse", EXPERIMENT): 0.5,
    ("design-dpdc", EXPERIMENT): 0.3,
    ("export-ssp", EXPERIMENT): 0.1,
    ("diagnose", CASE): 1.0,
    ("build", "--release", "--check"): 1.5,
    ("reproduce",): 1.0,
}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["ctrl-c", "sigterm"])
@pytest.mark.parametrize(("arguments", "at_work"), COMMANDS.items(), ids=[c[0] for c in COMMANDS])
def test_a_signal_ends_every_command_with_its_status_and_leaves_nothing(arguments, at_work, number, tmp_path):
    draw = random.Random(f"{arguments[0]} {number}")
    command = Command(tmp_path, arguments)
    command.wait_for_handlers()
    time.sleep(draw.uniform(0.0, at_work))
    status = command.end(number)

    said = command.errors.read_text()
    assert "Traceback" not in said, said
    assert status == 128 + number
    assert list(command.temporary.iterdir()) == []
    assert not list(tmp_path.rglob("*.ssp"))
    assert not list(tmp_path.rglob("*.partial"))


def started_writing(out, command):
    """Wait until a run has written a part of its rows."""
    while command.process.poll() is None and not list(out.glob("result.part-*.parquet")):
        time.sleep(0.02)


LONG = ["run", EXPERIMENT, "--stop-time", "10000", "--output"]


def test_after_a_kill_of_all_processes_rows_are_readable_and_the_folder_is_free(tmp_path):
    out = tmp_path / "out"
    command = Command(tmp_path, [*LONG, out])
    started_writing(out, command)
    assert command.end(signal.SIGKILL) == -signal.SIGKILL

    parts = sorted(out.glob("result.part-*.parquet"))
    time_ = np.concatenate([parquet.read_table(part)["time"].to_numpy() for part in parts])
    assert np.array_equal(time_, np.arange(len(time_)) * 0.001)
    assert len(time_) > 1
    again = tmp_path / "again"
    again.mkdir()
    short = ["run", EXPERIMENT, "--stop-time", "0.1", "--output", out]
    assert Command(again, short).process.wait() == 0
    assert not list(out.glob(".*"))
    assert not list(out.glob("result.part-*"))


def limited(n_bytes):
    """Let a process write files of so many bytes at most."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (n_bytes, n_bytes))


DISKS = [
    ("in memory", ["--stop-time", "20"], {"limit": limited(400_000)}),
    ("streamed", ["--stop-time", "110"], {"limit": limited(2_000_000)}),
    ("removed", ["--stop-time", "10000"], {"deed": shutil.rmtree}),
]


@pytest.mark.parametrize(("options", "how"), [d[1:] for d in DISKS], ids=[d[0] for d in DISKS])
def test_what_a_disk_does_not_take_is_said_with_status_3(options, how, tmp_path):
    out = tmp_path / "out"
    arguments = ["run", EXPERIMENT, *options, "--output", out]
    command = Command(tmp_path, arguments, preexec_fn=how.get("limit"))
    if "deed" in how:
        started_writing(out, command)
        how["deed"](out)
    assert command.process.wait(timeout=120.0) == 3

    said = command.errors.read_text()
    assert "Traceback" not in said, said
    assert "results cannot be written whole" in said
    report = json.loads((out / "summary.json").read_text())
    rows = read_csv(out / "result.csv")
    assert report["status"] == "failed"
    assert 1 < len(rows.time) <= report["steps"] + 1
    assert np.array_equal(rows.time, np.arange(len(rows.time)) * 0.001)
    assert list(command.temporary.iterdir()) == []


def replaced_by_a_file(out):
    """Put a file where the folder was."""
    shutil.rmtree(out)
    out.write_text("")


def made_read_only(out):
    """Let nobody make files in the folder any more."""
    out.chmod(0o555)


PLACES = [
    ("read-only, in memory", ["--stop-time", "5"], made_read_only, "takes no files any more"),
    ("read-only, streamed", ["--stop-time", "1000"], made_read_only, "Permission denied"),
    ("a file, streamed", ["--stop-time", "10000"], replaced_by_a_file, "removed during the run"),
]


@pytest.mark.parametrize(("options", "deed", "why"), [p[1:] for p in PLACES], ids=[p[0] for p in PLACES])
def test_what_a_folder_does_not_take_any_more_is_saved_next_to_it(options, deed, why, tmp_path):
    """A superuser may write anywhere: the command goes without that right."""
    through = ["setpriv", "--bounding-set=-dac_override,-dac_read_search"] if os.geteuid() == 0 else []
    if through and shutil.which(through[0]) is None:
        pytest.skip("a superuser may write anywhere, and there is no setpriv (util-linux) to give that up")
    out, rescued = tmp_path / "out", tmp_path / "out-rescued"
    command = Command(tmp_path, ["run", EXPERIMENT, *options, "--output", out], through=through)
    if "5" in options:
        while command.process.poll() is None and not (out / ".dockloop.lock").exists():
            time.sleep(0.001)
    else:
        started_writing(out, command)
    deed(out)
    assert command.process.wait(timeout=120.0) == 3

    said = command.errors.read_text()
    assert "Traceback" not in said, said
    assert f"{out}: results cannot be written whole: " in said
    assert why in said
    assert f"what could not be written there is in {rescued}" in said
    report = json.loads((rescued / "summary.json").read_text())
    table = parquet.read_table(rescued / "result.parquet")
    assert report["status"] == "failed"
    assert 1 < len(table) <= report["steps"] + 1
    assert np.array_equal(table["time"].to_numpy(), np.arange(len(table)) * 0.001)
    assert np.array_equal(read_csv(Path(report["files"]["csv"])).time, table["time"].to_numpy())
