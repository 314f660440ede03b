"""Variables that share a value: by one reference in FMI 2.0, by `Alias` elements in FMI 3.0."""

import pytest
import yaml

from master.errors import ConfigError
from master.experiment.prepare import Request, prepare
from master.fmi.description_reader import read_description
from master.stepping.outcome import RunOptions
from master.stepping.simulate import simulate
from tests.foreign.build import TYPES_3, describe_2, describe_3
from tests.foreign.foreign import COMPILED, run, wires

pytestmark = COMPILED

PORTS_2 = {"Real": (0, "0.25"), "Integer": (0, "-7"), "Enumeration": (2, "2"), "Boolean": (0, "true")}


def with_aliases_2():
    """Aliases of every input and output, before the variables that they are aliases of."""
    more = ""
    for name, (first, _) in PORTS_2.items():
        variability = "continuous" if name == "Real" else "discrete"
        declared = ' declaredType="Gear"' if name == "Enumeration" else ""
        for i, (end, causality) in enumerate((("in", "input"), ("out", "output"))):
            more += (
                f'<ScalarVariable name="{name}_{end}_too" valueReference="{first + i}" '
                f'causality="{causality}" variability="{variability}"><{name}{declared}/></ScalarVariable>'
            )
    return describe_2().replace("<ModelVariables>", "<ModelVariables>" + more)


def with_aliases_3():
    text = describe_3()
    for name in TYPES_3:
        for end in ("in", "out"):
            head, tail = text.split(f'<{name} name="{name}_{end}"')
            attributes, rest = tail.split("/>", 1)
            alias = f'<Alias name="{name}_{end}_too"/></{name}>'
            text = f'{head}<{name} name="{name}_{end}"{attributes}>{alias}{rest}'
    for name, kind in (("a", "Float64"), ("b", "Float64"), ("ia", "Int32"), ("ib", "Int32")):
        head, tail = text.split(f'<{kind} name="{name}"')
        array, rest = tail.split(f"</{kind}>", 1)
        text = f'{head}<{kind} name="{name}"{array}<Alias name="{name}_too"/></{kind}>{rest}'
    return text


def test_all_outputs_are_right_where_outputs_of_fmi_2_share_a_reference(fmu, tmp_path):
    fmu("2.0", with_aliases_2())
    start = {"Real_in": 0.25, "Integer_in_too": -7, "Enumeration_in": "high", "Boolean_in_too": True}
    result = run(tmp_path, {"a": {"source": "./types2.fmu", "start": start}}).result

    for name, value in (("Real", 0.25), ("Integer", -7.0), ("Enumeration", 2.0), ("Boolean", 1.0)):
        for alias in ("", "_too"):
            assert result[f"a.{name}_out{alias}"][-1] == value


@pytest.mark.parametrize(("out", "into"), [("", ""), ("_too", ""), ("", "_too"), ("_too", "_too")])
def test_wires_of_fmi_2_begin_and_end_at_aliases(fmu, tmp_path, out, into):
    fmu("2.0", with_aliases_2())
    start = {"Real_in": 0.25, "Integer_in": -7, "Enumeration_in": "high", "Boolean_in": True}
    fmus = {"a": {"source": "./types2.fmu", "start": start}, "b": {"source": "./types2.fmu"}}
    pairs = [(f"a.{name}_out{out}", f"b.{name}_in{into}") for name in PORTS_2]
    result = run(tmp_path, fmus, wires(*pairs)).result

    for name, value in (("Real", 0.25), ("Integer", -7.0), ("Enumeration", 2.0), ("Boolean", 1.0)):
        assert result[f"b.{name}_out"][-1] == result[f"b.{name}_out_too"][-1] == value


@pytest.mark.parametrize(("out", "into"), [("_too", ""), ("", "_too"), ("_too", "_too")])
def test_wires_of_fmi_3_begin_and_end_at_aliases(fmu, tmp_path, out, into):
    fmu("3.0", with_aliases_3())
    start = {f"{name}_in_too": 1 if name == "Boolean" else 100 for name in TYPES_3}
    fmus = {"a": {"source": "./types3.fmu", "start": start}, "b": {"source": "./types3.fmu"}}
    pairs = [(f"a.{name}_out{out}", f"b.{name}_in{into}") for name in TYPES_3]
    pairs += [(f"a.b{out}", f"b.a{into}"), (f"a.ib{out}", f"b.ia{into}")]
    result = run(tmp_path, fmus, wires(*pairs)).result

    for name in TYPES_3:
        value = 1.0 if name == "Boolean" else 100.0
        assert result[f"b.{name}_out"][-1] == result[f"b.{name}_out_too"][-1] == value
    of_b = [[result[f"b.{b}[{i},{j}]"][-1] for i in (1, 2) for j in (1, 2, 3)] for b in ("b", "b_too")]
    assert of_b == 2 * [[4.0, 8.0, 12.0, 16.0, 20.0, 24.0]]


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_two_wires_into_one_input_by_its_alias_are_refused(fmu, tmp_path, version):
    fmu(version, with_aliases_2() if version == "2.0" else with_aliases_3())
    name = "Real" if version == "2.0" else "Float64"
    fmus = {n: {"source": f"./types{version[0]}.fmu"} for n in "ab"}
    pairs = wires((f"a.{name}_out", f"b.{name}_in"), (f"a.{name}_out", f"b.{name}_in_too"))

    with pytest.raises(
        ConfigError, match=r"connections\[1\]\.to: has two sources, got 'b\.\w+_in_too' again, an alias"
    ):
        run(tmp_path, fmus, pairs)


def test_a_start_value_by_an_alias_of_a_connected_input_is_refused(fmu, tmp_path):
    fmu("2.0", with_aliases_2())
    fmus = {"a": {"source": "./types2.fmu"}, "b": {"source": "./types2.fmu", "start": {"Real_in_too": 1.0}}}

    with pytest.raises(ConfigError, match=r"start\.Real_in_too: has two sources, got a start value and a"):
        run(tmp_path, fmus, wires(("a.Real_out", "b.Real_in")))


def test_values_for_two_aliases_are_refused(fmu, tmp_path):
    fmu("3.0", with_aliases_3())
    start = {"Int8_in": 1, "Int8_in_too": 2}

    with pytest.raises(ConfigError, match="has two values, got 'Int8_in_too' and 'Int8_in', expected one of"):
        run(tmp_path, {"a": {"source": "./types3.fmu", "start": start}})


def test_set_events_limits_and_compare_take_aliases(fmu, tmp_path):
    fmu("2.0", with_aliases_2())
    given = {
        "name": "aliases",
        "step_size": 0.1,
        "stop_time": 0.5,
        "fmus": {"a": {"source": "./types2.fmu", "start": {"Real_in": 1.0}}, "b": {"source": "./types2.fmu"}},
        "coupling": {"order": ["a", "b"]},
        "connections": wires(("a.Real_out_too", "b.Real_in_too")),
        "events": [
            {"at": 0.2, "set": {"a.Real_in_too": 4.0}},
            {"when": "a.Real_out_too > 3", "offset": {"b.Real_in_too": 0.5}},
        ],
        "compare": {"signal": "b.Real_out_too", "offset": 1.0},
        "limits": {"b.Real_out_too": 10.0},
    }
    file = tmp_path / "system.yaml"
    file.write_text(yaml.safe_dump(given))
    experiment = prepare(file, Request(assignments=("a.Real_in_too=2",)))

    options = RunOptions(limits=experiment.limits, scenario=experiment.scenario)
    outcome = simulate(experiment.system, experiment.schedule, experiment.grid, options=options)

    assert outcome.status == "completed"
    assert outcome.result["a.Real_out"].tolist() == [2.0, 2.0, 2.0, 4.0, 4.0, 4.0]
    assert outcome.result["b.Real_out_too"][3:].tolist() == [4.0, 4.5, 4.5]


def test_a_loop_through_aliases_is_an_algebraic_loop(fmu, tmp_path):
    fmu("2.0", with_aliases_2())
    given = {
        "name": "loop",
        "step_size": 0.1,
        "stop_time": 0.5,
        "fmus": {n: {"source": "./types2.fmu"} for n in "ab"},
        "coupling": {"order": ["a", "b"]},
        "connections": wires(("a.Real_out_too", "b.Real_in_too"), ("b.Real_out", "a.Real_in_too")),
    }
    file = tmp_path / "system.yaml"
    file.write_text(yaml.safe_dump(given))

    [note] = prepare(file).notes
    assert note.startswith("algebraic loop ")


def test_an_alias_has_the_start_value_of_the_one_that_takes_it(fmu):
    description = read_description(fmu("2.0", with_aliases_2()))

    assert description.by_name["Boolean_in_too"].start == "false"
    assert description.primary("Boolean_out").name == "Boolean_out_too"
    assert description.primary("label").name == "label"
