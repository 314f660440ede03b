"""What a sandboxed FMU cannot do, and what it can do in a process of its own without a sandbox."""

import numpy as np
import pytest
from click.testing import CliRunner

from master.api import prepare_to_run
from master.cli import main
from master.experiment.prepare import Request
from master.isolation import sandbox
from master.stepping.simulate import simulate

from . import faulty
from .faulty import SYSTEM, Deed, When

needs_sandbox = pytest.mark.skipif(sandbox.what_is_missing() != "", reason=sandbox.what_is_missing())


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("sandboxed")
    faulty.build(made)
    return made


@pytest.fixture
def run(folder):
    def call(deed, version=2, **asked):
        file = folder / "system.yaml"
        given = {"deed": deed, "when": When.STEP, "first": 10, "stop": 0.05, "order": "[faulty, other]"}
        file.write_text(SYSTEM.format(version=version, more="", **given))
        experiment = prepare_to_run(file, Request(**asked))
        return simulate(experiment.system, experiment.schedule, experiment.grid)

    return call


@needs_sandbox
@pytest.mark.parametrize("version", [2, 3])
def test_a_sandboxed_fmu_writes_in_its_own_folder_only(run, tmp_path, monkeypatch, version):
    target = tmp_path / "outside"
    monkeypatch.setenv("FAULTY_FILE", str(target))

    said = {m.text for m in run(Deed.WRITE, version, sandbox=True).messages}

    assert said == {"could not write outside", "wrote inside", "could not make a folder"}
    assert not target.exists()
    assert "wrote outside" in {m.text for m in run(Deed.WRITE, version, isolate=("all",)).messages}
    assert target.exists()


@needs_sandbox
def test_a_sandboxed_fmu_has_no_network_and_reaches_no_other_process(run):
    said = {m.text for m in run(Deed.CONNECT, sandbox=True).messages}
    free = {m.text for m in run(Deed.CONNECT, isolate=("faulty",)).messages}

    assert said == {"no network", "no local sockets", "no signals to others"}
    assert free == {"a network", "local sockets", "signals to others"}


@needs_sandbox
@pytest.mark.parametrize("deed", [Deed.SEGFAULT, Deed.ABORT])
def test_a_crash_in_the_sandbox_is_named_as_outside(run, deed):
    outcome = run(deed, sandbox=True)

    assert f"killed by SIG{'SEGV' if deed is Deed.SEGFAULT else 'ABRT'}" in str(outcome.error)


@needs_sandbox
@pytest.mark.parametrize("version", [2, 3])
def test_the_sandbox_changes_no_bit(run, version):
    inside, shut_in = run(Deed.NOTHING, version), run(Deed.NOTHING, version, sandbox=True)

    assert np.array_equal(inside.result.values, shut_in.result.values)


@needs_sandbox
def test_a_sandbox_for_some_fmus_leaves_the_others_in_the_process_of_the_run(folder, run):
    run(Deed.NOTHING)
    experiment = prepare_to_run(folder / "system.yaml", Request(isolate=("other",), sandbox=True))

    instances = experiment.system.instances
    assert instances["other"].isolation.is_sandboxed
    assert instances["faulty"].isolation is None


def test_where_the_kernel_has_no_sandbox_the_command_says_so_and_runs_nothing(
    folder, run, monkeypatch, tmp_path
):
    run(Deed.NOTHING)
    monkeypatch.setattr(sandbox, "_landlock_version", lambda: 2)

    done = CliRunner().invoke(
        main, ["run", str(folder / "system.yaml"), "--sandbox", "--output", str(tmp_path / "out")]
    )

    assert done.exit_code == 2
    assert "--sandbox: no sandbox on this system, got Landlock 2 of the kernel" in done.output
    assert not (tmp_path / "out").exists()
