import pytest

from master.errors import ConfigError
from master.fmi.description_reader import read_description
from tests.foreign.build import TYPES_3
from tests.foreign.foreign import COMPILED, run, wires

pytestmark = COMPILED


def test_every_type_of_fmi_3_passes_from_one_fmu_to_the_next(fmu, tmp_path):
    fmu("3.0")
    start = {f"{name}_in": 1 if name == "Boolean" else 100 for name in TYPES_3}
    pairs = [(f"a.{name}_out", f"b.{name}_in") for name in TYPES_3]
    fmus = {"a": {"source": "./types3.fmu", "start": start}, "b": {"source": "./types3.fmu"}}
    outcome = run(tmp_path, fmus, wires(*pairs))

    assert outcome.status == "completed"
    for name in TYPES_3:
        assert outcome.result[f"b.{name}_out"][1:].tolist() == 5 * [1.0 if name == "Boolean" else 100.0]


def test_every_type_of_fmi_2_passes_from_one_fmu_to_the_next(fmu, tmp_path):
    fmu("2.0")
    start = {"Real_in": 0.1, "Integer_in": -7, "Enumeration_in": "high", "Boolean_in": True}
    pairs = [(f"a.{n}_out", f"b.{n}_in") for n in ("Real", "Integer", "Enumeration", "Boolean")]
    fmus = {"a": {"source": "./types2.fmu", "start": start}, "b": {"source": "./types2.fmu"}}
    result = run(tmp_path, fmus, wires(*pairs)).result

    last = [result[f"b.{n}_out"][-1] for n in ("Real", "Integer", "Enumeration", "Boolean")]
    assert last == [0.1, -7.0, 2.0, 1.0]


def test_a_start_value_that_a_type_does_not_hold_is_refused(fmu, tmp_path):
    fmu("3.0")
    with pytest.raises(ConfigError, match="Int8_in: value not allowed, got 300, expected at most 127"):
        run(tmp_path, {"a": {"source": "./types3.fmu", "start": {"Int8_in": 300}}})


def test_a_value_that_a_type_does_not_hold_ends_the_run(fmu, tmp_path):
    fmu("2.0"), fmu("3.0")
    fmus = {"a": {"source": "./types3.fmu"}, "b": {"source": "./types2.fmu"}}
    fmus["a"]["start"] = {"Int16_in": 300}
    connections = wires(("a.Int16_out", "b.Real_in"), ("b.Real_out", "a.Int8_in"))
    outcome = run(tmp_path, fmus, connections)

    assert (outcome.status, outcome.steps) == ("failed", 1)
    problem = "a.Int8_in: value does not fit Int8, got 300, expected from -128 to 127"
    assert str(outcome.error) == f"a at t=0.1 s: {problem}"


def test_the_elements_of_an_array_are_ports(fmu):
    description = read_description(fmu("3.0"))

    names = [v.name for v in description.variables if v.name.startswith("a[")]
    assert names == ["a[1,1]", "a[1,2]", "a[1,3]", "a[2,1]", "a[2,2]", "a[2,3]"]
    assert [description.by_name[n].start for n in names] == list("123456")
    assert description.by_name["ia[2]"].start == "0"
    assert "a[2,3]" in description.feedthrough["b[1,2]"]


def test_whole_arrays_are_wired_element_by_element(fmu, tmp_path):
    fmu("3.0")
    fmus = {
        "a": {"source": "./types3.fmu", "start": {"a[1,2]": 20.0, "ba[2]": True}},
        "b": {"source": "./types3.fmu"},
    }
    result = run(tmp_path, fmus, wires(("a.b", "b.a"), ("a.bb", "b.ba"))).result

    of_b = [result[f"b.b[{i},{j}]"][-1] for i in (1, 2) for j in (1, 2, 3)]
    assert of_b == [4.0, 80.0, 12.0, 16.0, 20.0, 24.0]
    assert [result[f"b.bb[{i}]"][-1] for i in (1, 2)] == [0.0, 1.0]


def test_arrays_of_different_shapes_and_an_element_twice_are_refused(fmu, tmp_path):
    fmu("3.0")
    fmus = {name: {"source": "./types3.fmu"} for name in "ab"}
    with pytest.raises(ConfigError) as caught:
        run(tmp_path, fmus, wires(("a.ib", "b.a"), ("a.bb", "b.ba"), ("a.ib[1]", "b.ba[2]")))

    shapes, twice = (problem.split(": ", 1)[1] for problem in caught.value.problems)
    assert shapes == "connections[0]: shapes differ, got a.ib up to [2] -> b.a up to [2,3], expected the same"
    assert twice.startswith("connections[2].to: has two sources, got 'b.ba[2]' again")


def test_an_array_element_is_wired_and_the_others_keep_their_start_values(fmu, tmp_path):
    fmu("3.0")
    fmus = {
        "a": {"source": "./types3.fmu", "start": {"a[1,2]": 20.0, "ia[2]": 5, "ba[1]": True}},
        "b": {"source": "./types3.fmu", "start": {"a[1,1]": -1.0}},
    }
    pairs = [
        ("a.b[1,2]", "b.a[2,3]"),
        ("a.ib[2]", "b.ia[1]"),
        ("a.bb[1]", "b.ba[2]"),
        ("a.b[2,3]", "b.Int8_in"),
    ]
    result = run(tmp_path, fmus, wires(*pairs)).result

    of_b = [result[f"b.b[{i},{j}]"][-1] for i in (1, 2) for j in (1, 2, 3)]
    assert of_b == [-2.0, 4.0, 6.0, 8.0, 10.0, 80.0]
    assert [result[f"b.ib[{i}]"][-1] for i in (1, 2)] == [20.0, 0.0]
    assert [result[f"b.bb[{i}]"][-1] for i in (1, 2)] == [1.0, 1.0]
    assert result["b.Int8_out"][-1] == 12.0


def test_an_event_sets_an_element_beside_a_wired_one(fmu, tmp_path):
    fmu("3.0")
    fmus = {name: {"source": "./types3.fmu"} for name in "ab"}
    event = {"at": 0.2, "for": 0.2, "set": {"b.a[1,1]": 5.0, "b.ba[2]": True}}
    outcome = run(tmp_path, fmus, wires(("a.b[1,2]", "b.a[2,3]")), events=[event])

    assert outcome.result["b.b[1,1]"].tolist() == [2.0, 2.0, 2.0, 10.0, 10.0, 2.0]
    assert outcome.result["b.bb[2]"].tolist() == [1.0, 1.0, 1.0, 0.0, 0.0, 1.0]
    assert outcome.result["b.b[2,3]"][1:].tolist() == 5 * [8.0]
