"""Connectors of the outermost system: inputs that can be driven, outputs that are columns of the result."""

import json
import zipfile

import numpy as np
import pytest

from master.errors import ConfigError
from master.experiment.prepare import Request, prepare
from master.ssp.export import write_ssp
from tests.master.ssp.boxes import run
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
NOT = (
    '<ssc:BooleanMappingTransformation><ssc:MapEntry source="true" target="false"/>'
    '<ssc:MapEntry source="false" target="true"/></ssc:BooleanMappingTransformation>'
)
TIMES = '<ssd:DefaultExperiment startTime="0" stopTime="0.004"/>'


def archive(folder, *elements, ports=(), wires=(), given="", files=None, name="root"):
    content = system(*elements, before=connectors(*ports) + given, after=links(*wires), name=name)
    return write(folder, structure(content, more=ENUMERATIONS + UNITS + TIMES), files)


def given(**values):
    return bindings(binding(parameter_set(*(parameter(name, *value) for name, value in values.items()))))


def last(result, name):
    return float(result[name][-1])


def test_an_output_of_the_system_is_a_column_with_its_transformation_and_unit(tmp_path):
    path = archive(
        tmp_path,
        component("a", given(u=("Real", "3"))),
        ports=(
            connector("plain", "output"),
            connector("scaled", "output"),
            connector("in mm", "output", "Real", "mm"),
            connector("inverted", "output", "Boolean"),
            connector("gear", "output", "Enumeration"),
        ),
        wires=(
            link("a.y", ".plain"),
            link("a.y", ".scaled", LINEAR),
            link("a.y", ".in mm"),
            link("a.b_y", ".inverted", NOT),
            link("a.e_y", ".gear"),
        ),
    )
    result = run(path).result

    assert last(result, "root.plain") == 3.0
    assert last(result, "root.scaled") == 7.0
    assert last(result, "root.in mm") == 3000.0
    assert last(result, "root.inverted") == 1.0
    assert last(result, "root.gear") == 1.0
    assert (result.unit("root.plain"), result.unit("root.in mm")) == ("m", "mm")
    assert len(result["root.scaled"]) == 5
    assert np.array_equal(run(path, compiled=True).result.values, result.values)


def test_an_input_of_the_system_feeds_all_that_it_is_connected_to(tmp_path):
    path = archive(
        tmp_path,
        component("a"),
        component("b"),
        ports=(connector("in", "input", "Real", "mm"),),
        wires=(link(".in", "a.u"), link(".in", "b.u", LINEAR), link(".in", "b.bare")),
        given=given(**{"in": ("Real", "5")}),
    )
    result = run(path).result

    assert last(result, "a.y") == 0.005
    assert last(result, "b.y") == 1.01
    assert last(result, "b.bare_y") == 5.0

    result = run(path, assignments=("root.in=1000",)).result

    assert last(result, "a.y") == 1.0
    assert last(result, "b.y") == 3.0
    assert last(result, "b.bare_y") == 1000.0


def test_a_parameter_of_the_system_is_set_by_the_archive_and_by_the_command(tmp_path):
    path = archive(
        tmp_path,
        component("a"),
        component("b"),
        ports=(
            connector("length", "parameter", "Real", "km"),
            connector("mode", "parameter", "Enumeration"),
            connector("label", "parameter", "String"),
        ),
        wires=(
            link(".length", "a.p"),
            link(".length", "b.p", LINEAR),
            link(".mode", "a.mode"),
            link(".label", "b.label"),
        ),
        given=given(length=("Real", "2")),
    )
    instances = prepare(path).system.instances

    assert (instances["a"].start, instances["b"].start) == ({"p": 2000.0}, {"p": 4001.0})

    changes = ("root.length=0.5", "root.mode=fast", "root.label=x=1")
    instances = prepare(path, Request(assignments=changes)).system.instances

    assert instances["a"].start == {"p": 500.0, "mode": 2.0}
    assert instances["b"].start == {"p": 1001.0, "label": "x=1"}


@pytest.mark.parametrize(
    ("assignment", "said"),
    [
        ("root.nix=1", "no such variable in root (the system), got 'nix', expected"),
        ("root.out=1", "cannot be set, got 'out'"),
        ("root.in=word", "value not allowed, got 'word' mm, expected a number"),
        ("root.mode=three", "value not allowed, got 'three', expected one of slow, fast"),
    ],
)
def test_a_wrong_value_for_a_connector_is_refused(tmp_path, assignment, said):
    path = archive(
        tmp_path,
        component("a"),
        ports=(
            connector("in", "input", "Real", "mm"),
            connector("out", "output"),
            connector("mode", "parameter", "Enumeration"),
        ),
        wires=(link(".in", "a.u"), link("a.y", ".out"), link(".mode", "a.mode")),
    )
    with pytest.raises(ConfigError, match="--set") as caught:
        prepare(path, Request(assignments=(assignment,)))

    assert said in str(caught.value)


def test_an_input_that_leads_to_an_output_of_the_system_hands_its_value_on(tmp_path):
    path = archive(
        tmp_path,
        component("a"),
        ports=(connector("in", "input", "Real", "m"), connector("out", "output", "Real", "mm")),
        wires=(link(".in", ".out"), link(".in", "a.u")),
        given=given(**{"in": ("Real", "5")}),
    )

    assert set(run(path).result["root.out"]) == {5000.0}
    assert set(run(path, assignments=("root.in=7",)).result["root.out"]) == {7000.0}


def annotated(path, **parts):
    """Add this project's annotation."""
    with zipfile.ZipFile(path) as opened:
        files = {name: opened.read(name) for name in opened.namelist()}
    text = files["SystemStructure.ssd"].decode()
    content = json.dumps(parts).replace("<", "&lt;").replace(">", "&gt;")
    note = f'<Coupling xmlns="org.dockloop.coupling">{content}</Coupling>'
    note = f'<ssc:Annotation type="org.dockloop.coupling">{note}</ssc:Annotation>'
    end = text.rindex("</ssd:System>")
    text = f"{text[:end]}<ssd:Annotations>{note}</ssd:Annotations>{text[end:]}"
    files["SystemStructure.ssd"] = text.encode()
    with zipfile.ZipFile(path, "w") as opened:
        for name, data in files.items():
            opened.writestr(name, data)
    return path


def driven(folder, **parts):
    path = archive(
        folder,
        component("a"),
        component("b"),
        ports=(connector("in", "input", "Real", "mm"), connector("out", "output", "Real", "mm")),
        wires=(link(".in", "a.u"), link(".in", "b.u", LINEAR), link("b.y", ".out")),
        files={"resources/x.csv": "time,F\n0,1\n0.001,2\n0.002,4\n0.003,8\n0.004,16\n"},
    )
    return annotated(path, **parts)


RECORDED = {"file": "resources/x.csv", "time": {"column": "time"}, "map": {"root.in": {"column": "F"}}}


def test_a_recording_drives_an_input_of_the_system(tmp_path):
    result = run(driven(tmp_path, inputs=RECORDED)).result

    assert result["a.y"] == pytest.approx([0.001, 0.002, 0.004, 0.008, 0.016], rel=1e-15)
    assert result["b.y"] == pytest.approx([1.002, 1.004, 1.008, 1.016, 1.032], rel=1e-15)
    assert result["root.out"] == pytest.approx([1002, 1004, 1008, 1016, 1032], rel=1e-15)


def test_a_recording_in_another_unit_is_converted_twice(tmp_path):
    recorded = {**RECORDED, "map": {"root.in": {"column": "F", "unit": "m"}}}

    assert last(run(driven(tmp_path, inputs=recorded)).result, "a.y") == 16.0


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"map": {"root.nix": {"column": "F"}}}, "no such input, got 'nix', expected one of in"),
        ({"map": {"root.out": {"column": "F"}}}, "no such input, got 'out'"),
        ({"map": {"root.in": {"column": "F"}, "a.u": {"column": "F"}}}, "has two sources, got 'a.u' again"),
        ({"map": {"root.in": {"column": "F", "unit": "kg"}}}, "unit does not fit, got 'kg', expected mm"),
        ({"file": "../x.csv"}, "outside the archive"),
        ({"file": "/etc/passwd"}, "outside the archive"),
        ({"file": "resources/nix.csv"}, "no such file, got 'resources/nix.csv'"),
    ],
)
def test_a_recording_that_does_not_fit_is_refused(tmp_path, change, said):
    with pytest.raises(ConfigError) as caught:
        prepare(driven(tmp_path, inputs={**RECORDED, **change}))

    assert said in str(caught.value)
    assert "s.ssp: SystemStructure.ssd:" in str(caught.value)


def test_an_event_sets_an_input_of_the_system_and_a_condition_watches_an_output(tmp_path):
    events = [
        {"at": 0.002, "set": {"root.in": 8}, "for": 0.001},
        {"when": "root.out > 1010", "set": {"b.bare": 3}},
    ]
    result = run(driven(tmp_path, events=events)).result

    # the step from 0.002 to 0.003 s has 8 mm; what was before comes back
    assert result["a.y"].tolist() == [0.0, 0.0, 0.0, 0.008, 0.0]
    assert result["b.y"].tolist() == [1.0 * 0, 0.0, 0.0, 1.016, 0.0]
    assert result["b.bare_y"].tolist() == [0.0, 0.0, 0.0, 0.0, 3.0]


def test_an_event_and_a_recording_on_one_input_are_refused(tmp_path):
    events = [{"at": 0.002, "set": {"a.u": 8}}]
    with pytest.raises(ConfigError, match=r"an event sets 'a\.u' too"):
        prepare(driven(tmp_path, inputs=RECORDED, events=events))


def test_a_limit_on_an_output_of_the_system_ends_a_run(tmp_path):
    outcome = run(driven(tmp_path, inputs=RECORDED, limits={"root.out": 1010}))

    assert outcome.status == "diverged"
    assert outcome.steps == 3
    assert "root.out: got 1016 mm, expected a magnitude of at most 1010 mm" in outcome.cause


def test_the_ledger_lists_outputs_of_the_system(tmp_path):
    entries = {e.target: e for e in prepare(driven(tmp_path, inputs=RECORDED)).ledger.entries}

    assert (entries["root.out"].source, entries["root.out"].least, entries["root.out"].most) == ("b.y", 0, 0)
    assert entries["b.u"].source == "resources/x.csv: F"


def test_a_calculated_parameter_can_be_an_output_of_the_system(tmp_path):
    path = archive(
        tmp_path,
        component("a", given(p=("Real", "3"))),
        ports=(connector("k", "calculatedParameter", "Real"),),
        wires=(link("a.k", ".k"),),
    )

    assert set(run(path).result["root.k"]) == {6.0}


def test_an_output_that_nothing_leads_to_is_a_note(tmp_path):
    path = archive(tmp_path, component("a"), ports=(connector("loose", "output"),))

    assert any("Connector 'loose': is connected to nothing" in note for note in prepare(path).notes)


def test_a_system_called_as_an_fmu_and_one_with_blanks_have_names_of_their_own(tmp_path):
    ports = (connector("out", "output"),)
    same = archive(tmp_path, component("a"), ports=ports, wires=(link("a.y", ".out"),), name="a")

    assert run(same).result.names[-1] == "a-2.out"
    assert "the system 'a' is called 'a-2' in signals" in prepare(same).notes

    blank = archive(tmp_path, component("a"), ports=ports, wires=(link("a.y", ".out"),), name="my system.1")

    assert run(blank).result.names[-1] == "my-system-1.out"


def test_connectors_of_the_system_come_back_from_an_archive_of_our_own(tmp_path):
    path = driven(
        tmp_path,
        inputs=RECORDED,
        limits={"root.out": 1e9},
        events=[{"when": "root.out > 1010", "set": {"b.bare": 3}}],
    )
    first, result = prepare(path), run(path).result
    again = write_ssp(first, tmp_path / "again.ssp")
    back = prepare(again)

    assert np.array_equal(run(again).result.values, result.values)
    assert run(again).result.names == result.names
    assert run(again).result.units == result.units
    assert back.ledger == first.ledger
    assert back.scenario == first.scenario
    assert back.limits == first.limits
    assert back.notes == first.notes


def test_values_of_connectors_come_back(tmp_path):
    path = archive(
        tmp_path,
        component("a"),
        ports=(connector("in", "input", "Real", "m"), connector("out", "output", "Real", "mm")),
        wires=(link(".in", ".out"), link(".in", "a.u")),
    )
    first = prepare(path, Request(assignments=("root.in=5", "a.u=7")))
    result = run(write_ssp(first, tmp_path / "again.ssp")).result

    assert set(result["root.out"]) == {5000.0}
    assert set(result["a.y"]) == {7.0}
