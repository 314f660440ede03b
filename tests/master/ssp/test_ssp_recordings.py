"""Recordings in archives: components that are tables, and the `inputs` of a system that is exported."""

import zipfile

import numpy as np
import pytest
import yaml
from click.testing import CliRunner
from scipy.io import savemat

from master.cli import main
from master.errors import ConfigError
from master.experiment.prepare import prepare
from master.ssp.export import write_ssp
from tests.master.ssp.boxes import run
from tests.master.ssp.random_systems import FMUS
from tests.master.ssp.ssp_archives import (
    ENUMERATIONS,
    UNITS,
    binding,
    bindings,
    component,
    connector,
    connectors,
    link,
    links,
    parameter,
    parameter_set,
    structure,
    system,
    write,
)

LINEAR = '<ssc:LinearTransformation factor="2" offset="1"/>'
TIMES = '<ssd:DefaultExperiment startTime="0" stopTime="0.004"/>'
CSV = "time,F,n,on\n0,1,3,0\n0.001,2,3,1\n0.002,4,5,1\n0.003,8,5,0\n0.004,16,7,1\n"
TABLE = 'type="text/csv"'


def table(*ports, name="data", source="resources/x.csv", kind=TABLE, inner=""):
    return component(name, inner, ports=ports, source=source, attributes=kind)


def archive(folder, *elements, wires=(), csv=CSV, ports=(), file="resources/x.csv", more=None, times=TIMES):
    content = system(*elements, before=connectors(*ports), after=links(*wires))
    files = {**({} if csv is None else {file: csv}), **(more or {})}
    return write(folder, structure(content, more=ENUMERATIONS + UNITS + times), files)


def faults(path):
    with pytest.raises(ConfigError) as caught:
        prepare(path)
    return "\n".join(caught.value.problems)


def test_a_table_drives_inputs_of_every_type_through_units_and_transformations(tmp_path):
    ports = (
        connector("F", "output", "Real", "mm"),
        connector("n", "output", "Integer"),
        connector("on", "output", "Boolean"),
    )
    path = archive(
        tmp_path,
        table(*ports),
        component("a"),
        component("b"),
        wires=(
            link("data.F", "a.u"),
            link("data.F", "b.u", LINEAR),
            link("data.n", "a.i"),
            link("data.on", "a.b"),
            link("data.F", ".out"),
        ),
        ports=(connector("out", "output", "Real", "m"),),
    )
    result = run(path).result

    # row 1 is what the step from 0 ms makes of the values at 0 ms; the system's output is read at its row
    assert result["a.y"] == pytest.approx([0.001, 0.001, 0.002, 0.004, 0.008], rel=1e-15)
    assert result["b.y"] == pytest.approx([1.002, 1.002, 1.004, 1.008, 1.016], rel=1e-15)
    assert result["a.i_y"].tolist() == [3, 3, 3, 5, 5]
    assert result["a.b_y"].tolist() == [0, 0, 1, 1, 0]
    assert result["root.out"] == pytest.approx([0.001, 0.002, 0.004, 0.008, 0.016], rel=1e-15)
    assert np.array_equal(run(path, compiled=True).result.values, result.values)


def test_between_samples_a_real_lies_on_the_line_and_an_integer_keeps_the_last_value(tmp_path):
    path = archive(
        tmp_path,
        table(connector("F", "output", "Real"), connector("n", "output", "Integer")),
        component("a"),
        wires=(link("data.F", "a.bare"), link("data.n", "a.i")),
        csv="n,t,F\n1,0,0\n5,0.004,8\n",
    )
    result = run(path).result

    assert result["a.bare_y"].tolist() == pytest.approx([0, 0, 2, 4, 6], abs=1e-14)
    assert result["a.i_y"].tolist() == [1, 1, 1, 1, 1]
    assert any(note.startswith("recordings: between two samples") for note in prepare(path).notes)


def test_a_table_in_a_nested_archive_is_read(tmp_path):
    inner = structure(
        system(
            table(connector("F", "output", "Real"), source="resources/x.csv"),
            before=connectors(connector("out", "output", "Real")),
            after=links(link("data.F", ".out")),
            name="inner",
        )
    )
    nested = tmp_path / "inner.ssp"
    with zipfile.ZipFile(nested, "w") as opened:
        opened.writestr("SystemStructure.ssd", inner)
        opened.writestr("resources/x.csv", CSV)
    sub = component(
        "sub",
        ports=(connector("out", "output", "Real"),),
        source="resources/inner.ssp",
        attributes='type="application/x-ssp-package"',
    )
    path = archive(
        tmp_path,
        sub,
        component("a"),
        wires=(link("sub.out", "a.bare"),),
        csv=None,
        more={"resources/inner.ssp": nested.read_bytes()},
    )

    assert run(path).result["a.bare_y"].tolist() == pytest.approx([1, 1, 2, 4, 8])


def test_a_table_may_be_a_mat_file_as_omsimulator_has_it(tmp_path):
    savemat(tmp_path / "x.mat", {"time": np.arange(5) * 1e-3, "F": 2.0 ** np.arange(5)})
    path = archive(
        tmp_path,
        table(connector("F", "output", "Real"), source="resources/x.mat", kind='type="application/table"'),
        component("a"),
        wires=(link("data.F", "a.bare"),),
        csv=None,
        more={"resources/x.mat": (tmp_path / "x.mat").read_bytes()},
    )

    assert run(path).result["a.bare_y"].tolist() == pytest.approx([1, 1, 2, 4, 8])


def test_a_table_gives_what_an_fmu_with_its_values_gives_next_to_the_others(tmp_path):
    """The FMU hands its input through in a step, as the table its row; both are components side by side."""
    path = archive(
        tmp_path,
        table(F),
        component("relay"),
        component("a"),
        component("b"),
        wires=(link("data.F", "a.bare"), link("data.F", "relay.bare"), link("relay.bare_y", "b.bare")),
    )
    result = run(path).result

    # the relay is one step late, its reader one more: as many steps as wires between components
    assert result["relay.bare_y"].tolist() == result["a.bare_y"].tolist()
    assert result["b.bare_y"].tolist() == pytest.approx([1, 1, 1, 2, 4])
    ages = {e.target: (e.least, e.most) for e in prepare(path).ledger.entries}
    assert ages["a.bare"] == ages["relay.bare"] == ages["b.bare"] == (1, 1)


F = connector("F", "output", "Real")


@pytest.mark.parametrize(
    ("element", "more", "said"),
    [
        (table(F), {"csv": "time,F\n0,1\n0.004,word\n"}, "Connector 'F': resources/x.csv: row 3, column 'F': got 'word'"),
        (table(F), {"csv": "time,G\n0,1\n0.004,2\n"}, "Connector 'F': resources/x.csv: no such column, got 'F', expected"),
        (table(F), {"csv": ""}, "Component 'data': source: the file is empty"),
        (table(F), {"csv": "time,F\n"}, "no samples"),
        (table(F), {"csv": "time,F\n0,1\n0.002,2\n"}, "ends at 0.002 s, expected a sample at or after the stop"),
        (table(F), {"csv": "time,F\n1,1\n2,2\n"}, "begins at 1 s, expected a sample at or before the start"),
        (table(F), {"csv": "time,F\n0,1\n0,2\n"}, "expected it to grow"),
        (table(F), {"csv": b"\x00\xff\xfe"}, "Component 'data'"),
        (table(F, source="resources/nix.csv"), {}, "no such file, got 'resources/nix.csv'"),
        (table(F, source="../x.csv"), {}, "outside the archive"),
        (table(connector("F", "input", "Real")), {}, "Connector 'F': a recording has outputs alone, got input"),
        (table(connector("F", "output", "String")), {}, "a recording has numbers alone, got String"),
        (table(F, inner=bindings(binding(parameter_set(parameter("F", "Real", "1"))))), {}, "values for a recording"),
        (table(connector("F", "output", "Real", "N")), {}, "units differ, got N -> m"),
    ],
)  # fmt: skip
def test_a_table_that_cannot_be_done_is_refused_by_element(tmp_path, element, more, said):
    found = faults(archive(tmp_path, element, component("a"), wires=(link("data.F", "a.u"),), **more))

    assert said in found
    assert f"{tmp_path}/s.ssp: SystemStructure.ssd:" in found
    assert "/dockloop-" not in found


def test_a_table_that_leads_nowhere_is_a_note(tmp_path):
    path = archive(tmp_path, table(F), component("a"), csv="no table")

    assert any("Component 'data': leads to no FMU" in note for note in prepare(path).notes)


def assert_comes_back(path, folder):
    first = prepare(path)
    again = write_ssp(first, folder / "again.ssp")
    back = prepare(again)

    assert np.array_equal(back.inputs.values, first.inputs.values)
    assert back.inputs.feeds == first.inputs.feeds
    assert back.ledger == first.ledger
    assert back.notes[len(back.notes) - len(first.notes) + 2 :] == first.notes[2:]
    return again


def test_a_table_comes_back_as_a_component(tmp_path):
    ports = (connector("F", "output", "Real", "mm"), connector("n", "output", "Integer"))
    wires = (link("data.F", "a.u", LINEAR), link("data.n", "a.i"))
    path = archive(tmp_path, table(*ports), component("a"), wires=wires)
    again = assert_comes_back(path, tmp_path)
    with zipfile.ZipFile(again) as opened:
        assert opened.read("resources/x.csv").decode() == CSV
        assert 'name="data" type="text/csv"' in opened.read("SystemStructure.ssd").decode()

    assert np.array_equal(run(again).result.values, run(path).result.values)


SYSTEM = {
    "name": "t",
    "step_size": 1e-3,
    "stop_time": 4e-3,
    "fmus": {
        name: {"source": str(FMUS / "force_sensor.fmu"), "parameters": {"sigma": 0, "T_f": 0}}
        for name in "ab"
    },
    "connections": [{"from": "a.f_mea", "to": "b.f_act"}],
    "coupling": {"order": ["a", "b"]},
}


def written(folder, **more):
    (folder / "my data.csv").write_text("t,F,G\n0,0,1\n1,1,2\n4,4,0\n")
    path = folder / "system.yaml"
    path.write_text(yaml.safe_dump({**SYSTEM, **more}))
    return path


def explained(path):
    return CliRunner().invoke(main, ["explain", str(path)]).output


@pytest.mark.parametrize("rule", ["hold", "linear"])
def test_inputs_of_a_system_come_back_with_the_same_bits_and_explanation(tmp_path, rule):
    column = {"column": "F", "unit": "kN"}
    inputs = {"file": "my data.csv", "time": {"column": "t", "unit": "ms"}, "map": {"a.f_act": column}}
    path = written(tmp_path, inputs=[{**inputs, "interpolation": rule}])
    first = prepare(path)
    again = write_ssp(first, tmp_path / "elsewhere" / "s.ssp")
    back = prepare(again)

    assert first.inputs.values[:, 0].tolist() == pytest.approx(
        [0, 1e3, 1e3, 1e3, 4e3] if rule == "hold" else [0, 1e3, 2e3, 3e3, 4e3]
    )
    assert np.array_equal(back.inputs.values, first.inputs.values)
    assert explained(again) == explained(path)
    assert "my data.csv: F -> a.f_act" in explained(again)
    rows = [
        CliRunner().invoke(main, ["run", str(p), "--output", str(tmp_path / p.stem)]) for p in (path, again)
    ]
    assert [done.exit_code for done in rows] == [0, 0]
    results = [(tmp_path / p.stem / "result.csv").read_bytes() for p in (path, again)]
    assert results[0] == results[1]


def test_connectors_of_a_yaml_system_come_back(tmp_path):
    connectors_ = {
        "plant.force": {"kind": "input", "unit": "kN", "start": 2},
        "plant.measured": {"kind": "output", "unit": "mN"},
    }
    connections = [
        *SYSTEM["connections"],
        {"from": "plant.force", "to": "a.f_act"},
        {"from": "b.f_mea", "to": "plant.measured"},
    ]
    path = written(tmp_path, connectors=connectors_, connections=connections)
    again = write_ssp(prepare(path), tmp_path / "s.ssp")

    assert explained(again) == explained(path)
    for p in (path, again):
        done = CliRunner().invoke(main, ["run", str(p), "--output", str(tmp_path / "out")])
        assert done.exit_code == 0, done.output
        header, *rows = (tmp_path / "out" / "result.csv").read_text().splitlines()
        assert header.endswith('"plant.measured"')
        assert float(rows[-1].rpartition(",")[2]) == 2e6
