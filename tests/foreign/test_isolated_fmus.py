"""FMUs in processes of their own: what they do there ends them alone, and changes no bit of the others."""

import contextlib
import os
import time
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from master.api import prepare_to_run
from master.cli import main
from master.errors import ConfigError, FmuError
from master.experiment.prepare import Request
from master.isolation.options import IS_POSSIBLE
from master.recording.files import read_csv
from master.stepping.opened import OpenRun
from master.stepping.outcome import COMPLETED, FAILED, RunOptions
from master.stepping.simulate import simulate
from tests.conftest import PROJECT

from . import faulty
from .faulty import SYSTEM, Deed, When

FIRST = 40

pytestmark = pytest.mark.skipif(not IS_POSSIBLE, reason="Linux on x86_64 or aarch64")

CALLS = {
    2: {When.STEP: "fmi2DoStep", When.SET: "fmi2SetXXX", When.GET: "fmi2GetXXX"},
    3: {When.STEP: "fmi3DoStep", When.SET: "fmi3SetXXX", When.GET: "fmi3GetXXX"},
}
ENDS = {
    Deed.SEGFAULT: ("killed by SIGSEGV", "after it said [faulty] about to fall"),
    Deed.ABORT: ("killed by SIGABRT",),
    Deed.EXIT: ("exit status 7",),
    Deed.HANG: ("did not return from", "within 1 s"),
    Deed.EAT: ("killed by SIGSEGV", "MB of memory where it may take 100 MB"),
}
FAST = (Deed.SEGFAULT, Deed.EXIT)
LIMITS = ", isolate: true, memory: 100"


def limits_for(deed):
    return f"{LIMITS}, deadline: 1.0" if deed is Deed.HANG else LIMITS


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("faulty")
    faulty.build(made)
    return made


@pytest.fixture
def prepared(folder):
    def call(
        deed=Deed.NOTHING,
        when=When.STEP,
        version=2,
        more=LIMITS,
        first=FIRST,
        stop=0.1,
        order="[faulty, other]",
        **asked,
    ):
        file = folder / "system.yaml"
        given = {"deed": deed, "when": when, "first": first, "stop": stop, "order": order}
        file.write_text(SYSTEM.format(version=version, more=more, **given))
        return prepare_to_run(file, Request(**asked))

    return call


def stepped(experiment):
    return simulate(experiment.system, experiment.schedule, experiment.grid)


def columns(outcome):
    return {name: outcome.result[name] for name in outcome.result.names}


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("when", CALLS[2])
@pytest.mark.parametrize(
    "deed", [*FAST, *(pytest.param(d, marks=pytest.mark.long) for d in ENDS if d not in FAST)]
)
def test_an_fmu_that_ends_or_hangs_is_named_with_call_and_time_and_the_rows_stay(
    prepared, deed, when, version
):
    outcome = stepped(prepared(deed, when, version, limits_for(deed)))

    assert outcome.status == FAILED
    assert outcome.error.instance == "faulty"
    assert outcome.error.status == "fatal"
    assert CALLS[version][when] in str(outcome.error)
    for text in ENDS[deed]:
        assert text in str(outcome.error)
    ticks = FIRST if when is When.SET else FIRST - 1
    assert outcome.steps == ticks
    assert outcome.error.time == pytest.approx(1e-3 * ticks)
    whole = stepped(prepared(version=version, more=""))
    for name, values in columns(outcome).items():
        if name not in ("faulty.deed", "faulty.when"):
            assert np.array_equal(values, columns(whole)[name][: ticks + 1]), name


@pytest.mark.parametrize("deed", [Deed.SEGFAULT, Deed.EXIT, Deed.HANG])
@pytest.mark.parametrize(("when", "call"), [(When.ENTER, "EnterInitializationMode"), (When.EXIT, "ExitInit")])
def test_an_fmu_that_ends_in_its_initialisation_is_named_with_the_call(prepared, deed, when, call):
    with pytest.raises(FmuError) as caught:
        stepped(prepared(deed, when, more=limits_for(deed), first=0))

    assert caught.value.instance == "faulty"
    assert f"fmi2{call}" in str(caught.value)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    "order", ["[faulty, other]", "[[faulty, other]]", "[{iterate: [faulty, other], tolerance: 1.0e-6}]"]
)
def test_isolated_and_in_process_have_the_same_bits(prepared, version, order):
    inside = stepped(prepared(version=version, order=order, more=""))
    for asked in ({"isolate": ("all",)}, {"isolate": ("faulty",)}, {"isolate": ("other",)}):
        outside = stepped(prepared(version=version, order=order, more="", **asked))

        assert outside.status == COMPLETED
        for name, values in columns(inside).items():
            assert np.array_equal(values, columns(outside)[name]), name


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("when", CALLS[2])
@pytest.mark.parametrize("deed", [Deed.SEGFAULT, pytest.param(Deed.HANG, marks=pytest.mark.long), Deed.ERROR])
def test_the_last_values_of_an_fmu_are_held_where_the_file_says_so(prepared, deed, when, version):
    outcome = stepped(prepared(deed, when, version, f"{limits_for(deed)}, on_fault: hold"))
    rows = columns(outcome)
    ticks = FIRST if when is When.SET else FIRST - 1

    assert outcome.status == COMPLETED
    assert outcome.steps == 100
    for name in ("faulty.x", "faulty.y", "faulty.n", "faulty.count"):
        assert np.all(rows[name][ticks:] == rows[name][ticks]), name
    assert rows["faulty.count"][ticks] == ticks
    assert rows["other.count"][-1] == 100
    [said] = [m for m in outcome.messages if m.category == "held"]
    assert said.fmu == "faulty"
    assert said.t == pytest.approx(1e-3 * ticks)
    assert "its last values are held" in said.text


def test_the_floating_point_mode_and_the_working_folder_of_an_fmu_are_its_own(prepared):
    plain = columns(stepped(prepared(more="")))
    here = os.getcwd()

    moved = stepped(prepared(Deed.MOVE))
    rounded = stepped(prepared(Deed.ROUND))

    assert os.getcwd() == here
    for outcome in (moved, rounded):
        assert outcome.status == COMPLETED
        for name in ("faulty.x", "other.x"):
            assert np.array_equal(columns(outcome)[name], plain[name])
    assert [m.category for m in rounded.messages] == ["floating point"]


@pytest.mark.parametrize("version", [2, 3])
def test_what_an_isolated_fmu_says_is_counted_as_in_process(prepared, version):
    said = []
    for more in ("", LIMITS):
        outcome = stepped(prepared(Deed.SAY, version=version, more=more))
        said.append([(m.fmu, m.status, m.category, m.text, m.count, m.t) for m in outcome.messages])

    assert said[0] == said[1]
    [(fmu, _, _, text, count, t)] = said[0]
    assert (fmu, text, count) == ("faulty", "a word", 61)
    assert t == pytest.approx(0.039)


def test_words_that_come_faster_than_they_can_be_kept_are_counted(prepared, monkeypatch):
    monkeypatch.setattr("master.isolation.channel._RING_BYTES", 2**14)

    outcome = stepped(prepared(Deed.CHATTER, more=", isolate: true", stop=0.042))

    counts = [m.count for m in outcome.messages if m.text == "a flood of words"]
    lost = [m.text for m in outcome.messages if "faster" in m.text]
    assert outcome.status == COMPLETED
    assert lost
    assert sum(counts) + sum(int(text.split()[0]) for text in lost) == 3000


def test_an_error_of_an_isolated_fmu_is_told_in_its_own_words(prepared):
    outcome = stepped(prepared(Deed.ERROR))

    assert str(outcome.error) == "faulty at t=0.039 s: [faulty] out of range"


def test_a_crash_at_the_very_end_spoils_no_rows(prepared):
    outcome = stepped(prepared(Deed.SEGFAULT, When.END))

    assert outcome.status == COMPLETED
    assert outcome.steps == 100
    [said] = [m for m in outcome.messages if m.category == "at the end"]
    assert "fmi2FreeInstance" in said.text


def children():
    """Processes of this one, in whichever thread they were started; zombies count."""
    tasks = Path("/proc/self/task").glob("*/children")
    return {process for task in tasks for process in task.read_text().split()}


def test_an_open_run_survives_its_fmu_and_leaves_no_process_or_folder(prepared, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    before = children()
    experiment = prepared(Deed.ABORT)
    run = OpenRun(experiment.system, experiment.schedule, experiment.grid, RunOptions())
    assert children() > before
    run.step(20)
    state = run.save()
    run.step(5)
    run.restore(state)
    with pytest.raises(FmuError, match=r"faulty at t=0\.039 s"):
        run.step(60)
    run.close()

    assert list(tmp_path.iterdir()) == []
    assert children() == before


def test_the_state_of_an_isolated_fmu_goes_out_as_bytes_and_comes_back():
    asked = Request(isolate=("spacecraft",), stop_time=0.1)
    experiment = prepare_to_run(PROJECT / "configs" / "low_frequency.yaml", asked)
    run = OpenRun(experiment.system, experiment.schedule, experiment.grid, RunOptions())
    slave = run._slaves["spacecraft"]
    position = experiment.system.instances["spacecraft"].description.by_name["s_des"]
    run.step(10)
    data, before = slave.state_bytes(), slave.get([position])
    run.step(20)
    assert slave.get([position]) != before
    slave.restore_bytes(data)

    assert slave.get([position]) == before
    run.close()


def test_an_isolated_fmu_ends_with_the_process_that_steps_it(prepared):
    experiment = prepared(Deed.HANG, more=", isolate: true, deadline: 1000")
    stepping = os.fork()
    if stepping == 0:
        try:
            stepped(experiment)
        finally:
            os._exit(0)
    until = time.monotonic() + 60
    while not (found := children_of(stepping)) and time.monotonic() < until:
        time.sleep(0.01)
    os.kill(stepping, 9)
    os.waitpid(stepping, 0)

    [process] = found
    until = time.monotonic() + 60
    while os.path.exists(f"/proc/{process}") and time.monotonic() < until:
        time.sleep(0.01)
    assert not os.path.exists(f"/proc/{process}")


def children_of(parent):
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            _, _, rest = stat.read_text().rpartition(")")
            if int(rest.split()[1]) == parent:
                found.append(int(stat.parent.name))
    return found


def test_the_command_ends_with_status_3_and_keeps_all_rows(prepared, folder, tmp_path):
    prepared(Deed.SEGFAULT, more="")

    done = CliRunner().invoke(
        main, ["run", str(folder / "system.yaml"), "--isolate", "faulty", "--output", str(tmp_path)]
    )

    assert done.exit_code == 3
    assert "faulty at t=0.039 s: ended its process, killed by SIGSEGV, in fmi2DoStep" in done.output
    assert len(read_csv(tmp_path / "result.csv")["faulty.x"]) == FIRST


def test_an_fmu_that_is_not_in_the_system_cannot_be_isolated(prepared):
    with pytest.raises(ConfigError, match="--isolate: no such FMU, got 'fualty', expected 'faulty'"):
        prepared(isolate=("fualty",))


@pytest.mark.parametrize("limit", ["on_fault: hold", "deadline: 3", "memory: 3"])
def test_an_fmu_with_a_limit_is_isolated_and_cannot_be_in_process(prepared, limit):
    assert prepared(more=f", {limit}").system.instances["faulty"].isolation is not None
    with pytest.raises(ConfigError, match="expected isolate: true"):
        prepared(more=f", isolate: false, {limit}")
