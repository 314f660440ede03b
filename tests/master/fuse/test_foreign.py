"""FMUs without sources that this project knows are carried in the fused FMU, and called there."""

from __future__ import annotations

import json
import tempfile
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
from master.fuse.description import describe_fmi2
from master.fuse.export import fused_system
from tests.conformance.material import FOLDER
from tests.foreign.build import FOLDERS, HERE, compile_c, describe_2, describe_3, write_fmu
from tests.master.fuse.fused_run import Host, assert_same_bits, bare, expected_rows, exported, prepared
from tests.master.fuse.systems import COUPLINGS, EVENTS, MEMBERS, loop, with_events

WIRES = [
    ("noise.f_mea", "two.Real_in"),
    ("two.Real_out", "three.Float64_in"),
    ("three.Float64_out", "three.Float32_in"),
    ("three.Float32_out", "three.Int8_in"),
    ("three.Int8_out", "other.Integer_in"),
    ("whole.push", "other.Real_in"),
    ("whole.count", "three.Int16_in"),
    ("three.Float32_out", "whole.coarse"),
    ("three.Int64_out", "whole.wide"),
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
        "connectors": {
            "whole.push": {"kind": "input", "type": "real", "start": 25},
            "whole.count": {"kind": "input", "type": "integer", "start": -9},
            "whole.coarse": {"kind": "output", "type": "real"},
            "whole.wide": {"kind": "output", "type": "integer"},
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


pytestmark = pytest.mark.slow


def test_it_is_valid_and_says_that_it_keeps_no_states_as_not_all_can(fused):
    description = read_description(fused)

    assert validate_fmu(str(fused)) == []
    assert not description.can_get_and_set_state
    assert not description.can_serialise_state


def test_fmus_of_both_versions_have_the_bits_of_run(experiment, host):
    names, values = expected_rows(experiment)
    shown = [name for name in names if name in host.variables]
    rows = host.start().rows(shown, experiment.grid.n_ticks, experiment.grid.step_size)

    assert {*shown} >= {
        "two.Integer_out",
        "three.Float32_out",
        "three.Int8_out",
        "whole.coarse",
        "whole.wide",
    }
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
    host.start(two__Boolean_in=True, whole__push=-3.0)
    host.fmu.doStep(0.0, 0.1)
    host.set("three.Int32_in", -41)
    host.set("whole.count", 12)
    host.fmu.doStep(0.1, 0.1)

    assert host.get("two.Boolean_out", "two.Integer_out", "three.Int32_out") == [1.0, 7.0, -41.0]
    assert host.get("other.Real_out", "three.Int16_out") == [-3.0, 12.0]


def test_what_a_carried_fmu_says_is_wrong_is_said_of_its_instance(host):
    host.start(two__answer=3)
    host.fmu.doStep(0.0, 0.1)
    host.fmu.doStep(0.1, 0.1)
    with pytest.raises(FMICallException):
        host.fmu.doStep(0.2, 0.1)
    if not host.is_2:
        assert host.messages == ["two: rope torn (fmi2DoStep answered with status error)"]


def test_an_input_that_the_type_of_a_carried_fmu_does_not_hold_is_refused(host):
    host.start()
    host.fmu.doStep(0.0, 0.1)
    host.set("whole.count", 40000)
    with pytest.raises(FMICallException):
        host.fmu.doStep(0.1, 0.1)
    if not host.is_2:
        assert host.messages == ["three: value does not fit Int16, got 40000.0"]


@pytest.mark.long
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


READS = """
static void take_value(Fmu *c, const char *resources) {
    char path[1024], *end = path;
    for (const char *at = resources + strlen("file://"); *at != '\\0'; end++) {
        unsigned code = (unsigned char)*at++;
        if (code == '%') {
            sscanf(at, "%2x", &code);
            at += 2;
        }
        *end = (char)code;
    }
    strcpy(end, "/value.txt");
    FILE *file = fopen(path, "r");
    if (file != NULL) {
        if (fscanf(file, "%lf", &c->Real[0]) != 1) {
            c->Real[0] = -1.0;
        }
        fclose(file);
    }
}

void *fmi2Instantiate("""


@pytest.mark.long
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_carried_fmu_reads_its_own_resources_wherever_a_host_unpacks_them(version, tmp_path, monkeypatch):
    text = (HERE / "types2.c").read_text(encoding="utf-8")
    text = "#include <stdio.h>\n" + text.replace("void *fmi2Instantiate(", READS, 1)
    text = text.replace(
        "c->callbacks = callbacks;", "c->callbacks = callbacks;\n    take_value(c, resources);"
    )
    source = tmp_path / "reads.c"
    source.write_text(text, encoding="utf-8")
    fmu = tmp_path / "reads.fmu"
    write_fmu(fmu, describe_2(), {"linux64/types.so": compile_c("2.0", tmp_path, source)})
    with zipfile.ZipFile(fmu, "a") as archive:
        archive.writestr("resources/value.txt", "42.5")
    data = mixed(fmus={"reads": {"source": str(fmu)}}, connections=[], connectors={})
    experiment = prepared(tmp_path, data | {"coupling": {"order": ["reads"]}})
    fused = exported(experiment, tmp_path, version)
    (tmp_path / "é 100%").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "é 100%"))
    host = Host(fused).start()
    host.fmu.doStep(0.0, 0.1)
    found = host.get("reads.Real_out")
    host.end()

    assert found == [42.5]


@pytest.mark.skipif(not FOLDER.is_dir(), reason=f"DOCKLOOP_FOREIGN: no such folder, got {FOLDER}")
@pytest.mark.long
def test_the_fmus_of_mastersims_suite_have_the_bits_of_run(tmp_path):
    folder = FOLDER / "mastersim" / "Math_003" / "fmus"
    data = {
        "name": "Math_003",
        "step_size": 0.01,
        "stop_time": 4.0,
        "fmus": {f"p{i}": {"source": str(folder / f"Part{i}.fmu")} for i in (1, 2, 3)},
        "coupling": {"order": ["p1", "p2", "p3"]},
        "connections": [
            {"from": "p1.x1", "to": "p2.x1"},
            {"from": "p1.x2", "to": "p2.x2"},
            {"from": "p2.x3", "to": "p3.x3"},
            {"from": "p3.x4", "to": "p2.x4"},
        ],
    }
    experiment = prepared(tmp_path, data)

    assert_same_bits(experiment, exported(experiment, tmp_path))


@pytest.mark.long
def test_fmus_of_another_tool_that_save_their_state_are_iterated_with_the_bits_of_run(tmp_path):
    data = COUPLINGS["iterated"]
    fmus = {n: dict(entry) for n, entry in data["fmus"].items()}
    for name in ("spacecraft", "contact"):
        fmus[name]["source"] = str(bare(tmp_path, fmus[name]["source"]))
    experiment = prepared(tmp_path, data | {"fmus": fmus})

    assert_same_bits(experiment, exported(experiment, tmp_path))


@pytest.fixture(scope="module")
def bare_loop(tmp_path_factory):
    """The loop under events, two of its FMUs of another tool that save their state."""
    folder = tmp_path_factory.mktemp("bare")
    events = [event for events in EVENTS.values() for event in events]
    order = [{"iterate": MEMBERS, "tolerance": 1e-9, "maximum": 80}, "free"]
    data = with_events(events, order, wires={})
    for name in ("spacecraft", "contact", "free"):
        data["fmus"][name]["source"] = str(bare(folder, data["fmus"][name]["source"]))
    return prepared(folder, data)


@pytest.mark.long
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_events_in_carried_fmus_have_the_bits_of_run(bare_loop, tmp_path, version):
    assert_same_bits(bare_loop, exported(bare_loop, tmp_path, version))


@pytest.mark.long
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_states_of_carried_fmus_that_save_theirs_bring_back_every_later_row(bare_loop, tmp_path, version):
    fmu = exported(bare_loop, tmp_path, version)
    names, values = expected_rows(bare_loop)
    h = bare_loop.grid.step_size
    host = Host(fmu).start()
    save, restore, forget = (
        (host.fmu.getFMUstate, host.fmu.setFMUstate, host.fmu.freeFMUstate)
        if host.is_2
        else (host.fmu.getFMUState, host.fmu.setFMUState, host.fmu.freeFMUState)
    )
    host.rows(names, 33, h)
    early = save()
    host.rows(names, 30, h, 33 * h)
    late = save()
    from_late = host.rows(names, 50, h, 63 * h)
    restore(early)
    from_early = host.rows(names, 80, h, 33 * h)
    restore(late)
    again = host.rows(names, 50, h, 63 * h)
    host.fmu.reset()
    anew = host.start().rows(names, 60, h)
    restore(early)
    after_reset = host.rows(names, 80, h, 33 * h)
    forget(early)
    forget(late)
    description = read_description(fmu)
    host.end()

    assert validate_fmu(str(fmu)) == []
    assert description.can_get_and_set_state
    assert not description.can_serialise_state
    assert from_late.tobytes() == values[63:114].tobytes()
    assert from_early.tobytes() == values[33:114].tobytes()
    assert again.tobytes() == from_late.tobytes()
    assert anew.tobytes() == values[:61].tobytes()
    assert after_reset.tobytes() == from_early.tobytes()


@pytest.mark.long
def test_a_state_of_another_instance_is_refused(bare_loop, tmp_path):
    fmu = exported(bare_loop, tmp_path, "3.0")
    one, other = Host(fmu, "one").start(), Host(fmu, "other").start()
    state = one.fmu.getFMUState()
    with pytest.raises(FMICallException):
        other.fmu.setFMUState(state)
    said = other.messages[-1]
    one.fmu.freeFMUState(state)
    one.end()
    other.end()

    assert said.startswith("FMU state: got none of this instance")


@pytest.mark.long
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


def test_units_of_one_name_that_mean_different_things_are_refused(tmp_path):
    def with_unit(name: str, definition: str) -> dict:
        real = '<Real start="0"'
        text = (
            describe_2()
            .replace(real, f'{real} unit="C"')
            .replace("<TypeDefinitions>", f"<UnitDefinitions>{definition}</UnitDefinitions><TypeDefinitions>")
        )
        write_fmu(tmp_path / f"{name}.fmu", text, {"linux64/types.so": compile_c("2.0", tmp_path)})
        return {"source": str(tmp_path / f"{name}.fmu")}

    coulomb = with_unit("coulomb", '<Unit name="C"><BaseUnit A="1" s="1"/></Unit>')
    celsius = with_unit("celsius", '<Unit name="C"><BaseUnit K="1" offset="273.15"/></Unit>')
    named = with_unit("named", '<Unit name="C"/>')
    more = {"connections": [], "connectors": {}}

    def fused(**fmus):
        data = mixed(fmus=fmus, **more) | {"coupling": {"order": [*fmus]}}
        return fused_system(prepared(tmp_path, data), carries=True)

    with pytest.raises(ConfigError) as refused:
        fused(a=coulomb, b=celsius)
    [problem] = refused.value.problems
    assert problem.startswith("fmus.b: unit 'C' of Real_in is another than that of a.Real_in")
    assert b'<Unit name="C" />' in describe_fmi2(fused(a=named), "", ())
    assert b'<BaseUnit s="1" A="1"' in describe_fmi2(fused(a=named, b=coulomb), "", ())


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


@pytest.mark.long
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
