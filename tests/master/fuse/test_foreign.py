"""FMUs without sources that this project knows are carried in the fused FMU, and called there."""

from __future__ import annotations

import json
import zipfile

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from fmu_sources.export import build
from master.cli import main
from master.errors import ConfigError
from master.fmi.description_reader import read_description
from master.fuse.export import fused_system
from tests.foreign.build import FOLDERS, compile_c, describe_2, describe_3, write_fmu
from tests.master.fuse.fused_run import Host, assert_same_bits, expected_rows, exported, prepared
from tests.master.fuse.systems import COUPLINGS, MEMBERS, loop

WIRES = [
    ("noise.f_mea", "two.Real_in"),
    ("two.Real_out", "three.Float64_in"),
    ("three.Float64_out", "three.Float32_in"),
    ("three.Float32_out", "three.Int8_in"),
    ("three.Int8_out", "other.Integer_in"),
]


def mixed(**more) -> dict:
    """An FMU of this project and FMUs of both versions without sources, with wires of many types."""
    return {
        "name": "mixed",
        "step_size": 0.1,
        "stop_time": 2.0,
        "fmus": {
            "noise": {"source": "force_sensor", "parameters": {"sigma": 3.0, "seed": 3}},
            "two": {
                "source": "./types2.fmu",
                "parameters": {"label": "rope torn"},
                "start": {"Integer_in": 7},
            },
            "three": {"source": "./types3.fmu"},
            "other": {"source": "./types2.fmu"},
        },
        "connections": [{"from": source, "to": target} for source, target in WIRES],
        "coupling": {"order": ["noise", "two", "three", "other"]},
    } | more


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("foreign")
    for version, platform in FOLDERS.items():
        text = describe_2() if version == "2.0" else describe_3()
        library = compile_c(version, folder)
        write_fmu(folder / f"types{version[0]}.fmu", text, {f"{platform}/types.so": library})
    return folder


@pytest.fixture(scope="module")
def experiment(folder):
    return prepared(folder, mixed())


@pytest.fixture(scope="module", params=["2.0", "3.0"])
def fused(experiment, folder, request):
    return exported(experiment, folder, request.param)


@pytest.fixture
def host(fused):
    host = Host(fused)
    yield host
    host.end()


def bare(folder, model: str):
    """Write a model of this project as the FMU of another tool, without its sources."""
    path = folder / f"bare_{model}.fmu"
    with zipfile.ZipFile(build.target(model).path) as archive, zipfile.ZipFile(path, "w") as copy:
        for name in archive.namelist():
            if not name.startswith("sources/"):
                content = archive.read(name)
                copy.writestr(name, content.replace(b"dockloop (native flavour)", b"another tool"))
    return path


pytestmark = [pytest.mark.slow, pytest.mark.long]


def test_it_is_valid_and_says_that_it_keeps_no_states(fused):
    description = read_description(fused)

    assert validate_fmu(str(fused)) == []
    assert not description.can_get_and_set_state
    assert not description.can_serialise_state


def test_fmus_of_both_versions_have_the_bits_of_run(experiment, host):
    names, values = expected_rows(experiment)
    shown = [name for name in names if name in host.variables]
    rows = host.start().rows(shown, experiment.grid.n_ticks, experiment.grid.step_size)

    assert {*shown} >= {"two.Integer_out", "three.Float32_out", "three.Int8_out", "other.Integer_out"}
    assert len(np.unique(rows)) > 20
    for j, name in enumerate(shown):
        assert rows[:, j].tobytes() == values[:, names.index(name)].tobytes(), name


def test_what_it_carries_is_the_whole_archive(folder, fused):
    with zipfile.ZipFile(fused) as archive, zipfile.ZipFile(folder / "types3.fmu") as inner:
        names = archive.namelist()
        [library] = [name for name in names if name.endswith("binaries/x86_64-linux/types.so")]
        place = library.removesuffix("binaries/x86_64-linux/types.so")

        assert place.startswith("resources/types_")
        assert {n.removeprefix(place) for n in names if n.startswith(place)} == {*inner.namelist()}
        assert all(archive.read(place + name) == inner.read(name) for name in inner.namelist())


def test_inputs_and_parameters_of_a_carried_fmu_are_those_of_the_host(host):
    host.start(two__Boolean_in=True)
    host.fmu.doStep(0.0, 0.1)
    host.set("three.Int32_in", -41)
    host.fmu.doStep(0.1, 0.1)

    assert host.get("two.Boolean_out", "two.Integer_out", "three.Int32_out") == [1.0, 7.0, -41.0]


def test_what_a_carried_fmu_says_is_wrong_is_said_of_its_instance(host):
    host.start(two__answer=3)
    host.fmu.doStep(0.0, 0.1)
    host.fmu.doStep(0.1, 0.1)
    with pytest.raises(FMICallException):
        host.fmu.doStep(0.2, 0.1)
    if not host.is_2:
        assert host.messages == ["two: rope torn (fmi2DoStep answered with status error)"]


def test_instances_share_nothing_and_a_reset_one_repeats_its_run(experiment, fused):
    names = ["two.Real_out", "three.Float64_out", "two.Integer_out"]
    one, other = Host(fused, "one"), Host(fused, "other")
    one.start(two__Integer_in=1)
    other.start(two__Integer_in=2)
    first = one.rows(names, 5, 0.1)
    second = other.rows(names, 5, 0.1)
    one.fmu.reset()
    again = one.start().rows(names, 5, 0.1)
    one.end()
    other.end()

    assert (first[:, 2].tolist()[-1], second[:, 2].tolist()[-1]) == (1.0, 2.0)
    assert first[:, :2].tobytes() == second[:, :2].tobytes() == again[:, :2].tobytes()
    assert again[-1, 2] == 7.0


def test_a_carried_library_that_is_missing_is_named(fused, tmp_path):
    copy = tmp_path / "without.fmu"
    with zipfile.ZipFile(fused) as archive, zipfile.ZipFile(copy, "w") as without:
        for name in archive.namelist():
            if not (name.startswith("resources/") and name.endswith(".so")):
                without.writestr(name, archive.read(name))
    host = Host.__new__(Host)
    with pytest.raises(Exception, match="Failed to instantiate"):
        host.__init__(copy)

    if not host.is_2:
        [message] = host.messages
        assert message.startswith("other: cannot be loaded: ")
        assert "/binaries/linux64/types.so" in message


@pytest.mark.parametrize("coupling", ["iterated", "waveform"])
def test_an_fmu_of_another_tool_in_any_coupling_has_the_bits_of_run(coupling, tmp_path):
    data = COUPLINGS[coupling]
    fmus = {n: dict(entry) for n, entry in data["fmus"].items()}
    for name in ("spacecraft", "contact"):
        fmus[name]["source"] = str(bare(tmp_path, fmus[name]["source"]))
    experiment = prepared(tmp_path, data | {"fmus": fmus})

    assert_same_bits(experiment, exported(experiment, tmp_path))


def test_the_command_carries_it_and_refuses_other_platforms_by_name(folder, tmp_path):
    path = folder / "command.yaml"
    path.write_text(yaml.safe_dump(mixed()), encoding="utf-8")
    given = ["export-fmu", str(path), "--output", str(tmp_path / "loop.fmu"), "--json"]
    done = CliRunner().invoke(main, given)
    refused = CliRunner().invoke(main, [*given, "--all-platforms"])

    assert json.loads(done.stdout)["fmus"] == 4
    assert (done.exit_code, refused.exit_code) == (0, 2)
    [problem] = json.loads(refused.stdout)["problems"]
    assert problem.startswith("--all-platforms: ")
    assert "got other, three, two, expected" in problem


def test_connections_and_start_values_of_arrays_are_refused_by_name(folder):
    data = mixed()
    data["connections"].append({"from": "two.Real_out", "to": "three.a[1,1]"})
    data["fmus"]["three"]["start"] = {"ia[1]": 3}

    with pytest.raises(ConfigError) as refused:
        fused_system(prepared(folder, data), carries=True)
    start, wire = sorted(refused.value.problems)
    assert start.startswith(
        "fmus.three: a start value of an array of an FMU that is carried along, got ia[1]"
    )
    assert wire.startswith("fmus.three: an array of an FMU that is carried along, got a[1,1]")


def test_a_campaigns_runs_have_no_fused_form_with_it(tmp_path):
    changed = tmp_path / "changed.fmu"
    with (
        zipfile.ZipFile(build.target("docking_contact").path) as archive,
        zipfile.ZipFile(changed, "w") as copy,
    ):
        for name in archive.namelist():
            content = archive.read(name)
            copy.writestr(name, content + b"\n" if name == "sources/step.c" else content)
    other = {"source": str(bare(tmp_path, "spacecraft"))}
    experiment = prepared(tmp_path, loop(MEMBERS, spacecraft=other, contact={"source": str(changed)}))

    with pytest.raises(ConfigError) as refused:
        fused_system(experiment)
    contact, spacecraft = sorted(refused.value.problems)
    assert contact.startswith("fmus.contact: ")
    assert "step.c missing or of another version" in contact
    assert spacecraft.startswith("fmus.spacecraft: ")
    assert "an FMU of another tool" in spacecraft
