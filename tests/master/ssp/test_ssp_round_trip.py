"""A system written as SSP and read back: the same bits, the same explanation, valid files for other tools."""

import json
import zipfile
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from lxml import etree

from master.cli import main
from master.errors import ConfigError, FmuError
from master.experiment.prepare import Request, prepare
from master.ssp.export import write_ssp
from master.stepping.outcome import RunOptions
from master.stepping.simulate import simulate
from master.system.grid import Grid
from tests.master.ssp.random_systems import FMUS, random_system

SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"
CONFIGS = Path(__file__).parents[3] / "configs"
N_TICKS = 200


def written(folder, data):
    path = folder / "system.yaml"
    path.write_text(yaml.safe_dump(data, allow_unicode=True), encoding="utf-8")
    return path


def values(experiment):
    grid = Grid(experiment.grid.t0, experiment.grid.step_size, min(N_TICKS, experiment.grid.n_ticks))
    options = RunOptions(limits=experiment.limits, scenario=experiment.scenario)
    try:
        outcome = simulate(experiment.system, experiment.schedule, grid, options=options)
    except FmuError as error:  # the initial values of some random systems do not settle
        return "failed", str(error), np.empty(0)
    return outcome.status, str(outcome.error), outcome.result.values


def explained(path, *options):
    return CliRunner().invoke(main, ["explain", str(path), *options]).output


def assert_comes_back(config, folder, **request):
    first = prepare(config, Request(**request))
    archive = write_ssp(first, folder / "system.ssp")
    back = prepare(archive)
    status, error, rows = values(first)
    status_back, error_back, rows_back = values(back)

    assert (status_back, error_back) == (status, error)
    assert np.array_equal(rows_back, rows, equal_nan=True)
    assert back.schedule == first.schedule
    assert back.ledger == first.ledger
    assert back.scenario == first.scenario
    assert back.limits == first.limits
    assert back.notes == first.notes
    assert (back.config.name, back.config.description) == (first.config.name, first.config.description)
    assert [(w.source.name, w.target.name, w.delay, w.conversion) for w in back.system.wires] == [
        (w.source.name, w.target.name, w.delay, w.conversion) for w in first.system.wires
    ]
    assert_valid(archive)
    return archive


def assert_valid(archive):
    with zipfile.ZipFile(archive) as opened:
        for name in opened.namelist():
            schema = {"ssd": "Description", "ssv": "ParameterValues"}.get(name.rpartition(".")[2])
            if schema is not None:
                checked = etree.XMLSchema(etree.parse(str(SCHEMAS / f"SystemStructure{schema}.xsd")))
                checked.assertValid(etree.fromstring(opened.read(name)))


def comes_back(seed, folder):
    try:
        prepare(written(folder, random_system(seed)))
    except ConfigError as error:
        pytest.fail(f"the generator made a system that is refused: {error}")
    assert_comes_back(folder / "system.yaml", folder)


@pytest.mark.parametrize("seed", range(12))
def test_a_random_system_comes_back(tmp_path, seed):
    comes_back(seed, tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(12, 300))
def test_any_random_system_comes_back(tmp_path, seed):
    comes_back(seed, tmp_path)


def configurations():
    for path in sorted([*CONFIGS.glob("*.yaml"), *CONFIGS.glob("hexapod/*.yaml")]):
        variants = yaml.safe_load(path.read_text(encoding="utf-8")).get("variants", {})
        for variant in (None, *variants):
            yield pytest.param(path, variant, id=f"{path.parent.name}-{path.stem}-{variant}")


@pytest.mark.long
@pytest.mark.parametrize(("path", "variant"), list(configurations()))
def test_every_configuration_comes_back(tmp_path, path, variant):
    archive = assert_comes_back(path, tmp_path, variant=variant)
    options = [] if variant is None else ["--variant", variant]

    assert explained(archive) == explained(path, *options)


def sensor(**more):
    return {"source": str(FMUS / "force_sensor.fmu"), "parameters": {"sigma": 0}, **more}


LOOP = {
    "name": "t",
    "step_size": 1e-3,
    "stop_time": 5e-3,
    "fmus": {"a": sensor(start={"f_act": 1}), "b": sensor()},
    "connections": [{"from": "a.f_mea", "to": "b.f_act"}],
}


def test_a_system_without_an_order_comes_back_without_one(tmp_path):
    archive = assert_comes_back(written(tmp_path, LOOP), tmp_path)

    assert prepare(archive).config.coupling.order is None


def test_a_wire_of_converted_units_comes_back_and_other_tools_find_a_linear_transformation(tmp_path):
    data = {**LOOP, "connections": [{"from": "a.f_mea", "to": "b.f_act", "factor": 0.1, "offset": 1 / 3}]}
    archive = assert_comes_back(written(tmp_path, data), tmp_path)
    with zipfile.ZipFile(archive) as opened:
        text = opened.read("SystemStructure.ssd").decode()

    assert 'suppressUnitConversion="true"' in text
    assert '<ssc:LinearTransformation factor="0.1" offset="0.3333333333333333"/>' in text


def test_variants_come_back_with_a_system_of_none(tmp_path):
    data = {**LOOP, "variants": {"big": {"a": {"f_act": 7}}}}
    archive = assert_comes_back(written(tmp_path, data), tmp_path)

    assert prepare(archive, Request(variant="big")).system.instances["a"].start["f_act"] == 7.0


def edited(archive, change):
    with zipfile.ZipFile(archive) as opened:
        files = {name: opened.read(name) for name in opened.namelist()}
    files["SystemStructure.ssd"] = change(files["SystemStructure.ssd"].decode()).encode()
    with zipfile.ZipFile(archive, "w") as opened:
        for name, content in files.items():
            opened.writestr(name, content)
    return archive


def export(folder, data):
    return write_ssp(prepare(written(folder, data)), folder / "system.ssp")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "a.f_mea",
            "a.nix",
            "Coupling: no such connection, got a.nix -> b.f_act, expected one of the system",
        ),
        ('"delay": 2', '"delay": -2', "Connection a.f_mea - b.f_act"),
        ('"delay": 2', '"dealy": 2', "Coupling: connections[0]: unknown key, expected 'delay'"),
        ('"every": {}', '"evry": {}', "Coupling: unknown key, expected 'every'"),
        ('"every": {}', '"every": {"c": 2}', "Coupling: no such FMU, got 'c'"),
        ('"every": {}', '"every": []', "every is not understood, got []"),
        ('"every": {}', '"every": {"a": "x"}', "Component 'a'"),
        ('{"connections"', '["connections"', "Coupling: not JSON"),
        ('"step_size": 0.001', '"step_size": "fast"', "step_size is not a number, got 'fast'"),
        ('"step_size": 0.001', '"start": {"a": 3}', "start of a is not understood, got 3"),
        ('"step_size": 0.001', '"limits": {"a.nix": 1}', "Annotation: limits: no such output of a"),
    ],
)
def test_an_annotation_that_does_not_fit_is_refused(tmp_path, old, new, said):
    data = {**LOOP, "connections": [{"from": "a.f_mea", "to": "b.f_act", "delay": 2}]}
    archive = export(tmp_path, data)
    edited(archive, lambda text: text.replace(old, new))
    with pytest.raises(ConfigError) as caught:
        prepare(archive)

    assert said in str(caught.value)
    assert "SystemStructure.ssd:" in str(caught.value)


def test_values_that_another_tool_changes_count(tmp_path):
    archive = export(tmp_path, LOOP)
    with zipfile.ZipFile(archive) as opened:
        files = {name: opened.read(name) for name in opened.namelist()}
    files["resources/a.ssv"] = files["resources/a.ssv"].replace(b'value="1.0"', b'value="8.0"')
    with zipfile.ZipFile(archive, "w") as opened:
        for name, content in files.items():
            opened.writestr(name, content)

    assert prepare(archive).system.instances["a"].start["f_act"] == 8.0


def test_a_nested_system_with_a_coupling_of_its_own_is_refused(tmp_path):
    from tests.master.ssp.ssp_archives import system, write

    inner = export(tmp_path, LOOP).read_bytes()
    sub = '<ssd:Component name="sub" source="resources/sub.ssp" type="application/x-ssp-package"/>'
    with pytest.raises(ConfigError, match="coupling of a system within another is not understood"):
        prepare(write(tmp_path, system(sub), {"resources/sub.ssp": inner}))


def test_what_an_ssp_cannot_hold_is_refused_at_export(tmp_path):
    experiment = prepare(written(tmp_path, LOOP))
    config = experiment.config.model_copy(update={"description": "bell \x07"})
    with pytest.raises(ConfigError, match="got a character that XML does not have"):
        write_ssp(replace(experiment, config=config), tmp_path / "s.ssp")


def test_a_file_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="cannot be written"):
        write_ssp(prepare(written(tmp_path, LOOP)), tmp_path / "file" / "s.ssp")


def invoke(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


def test_every_command_takes_an_archive_and_an_unpacked_structure_as_it_takes_yaml(tmp_path):
    config = written(tmp_path, LOOP)
    archive = export(tmp_path, LOOP)
    with zipfile.ZipFile(archive) as opened:
        opened.extractall(tmp_path / "unpacked")
    structure = tmp_path / "unpacked" / "SystemStructure.ssd"
    for command in ("check", "explain", "analyse"):
        answers = [invoke(command, path, "--json") for path in (config, archive, structure)]
        assert [a.exit_code for a in answers] == [answers[0].exit_code] * 3
        assert answers[1].output == answers[2].output == answers[0].output
    for path in (archive, structure):
        done = invoke("run", path, "--step-size", "0.005", "--output", tmp_path / "o", "--json")
        assert done.exit_code == 0
        assert json.loads(done.stdout)["steps"] == 1


@pytest.mark.long
def test_a_design_is_the_same_from_an_archive(tmp_path):
    config = CONFIGS / "low_frequency.yaml"
    archive = write_ssp(prepare(config), tmp_path / "s.ssp")

    assert invoke("design-dpdc", archive, "--json").output == invoke("design-dpdc", config, "--json").output


def test_export_names_its_file_without_leaving_its_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = invoke("export-ssp", written(tmp_path, {**LOOP, "name": "..out: side"}))

    assert done.exit_code == 0
    assert [p.name for p in (tmp_path / "results").iterdir()] == ["out_ side.ssp"]
