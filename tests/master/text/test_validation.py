from pathlib import Path
from typing import Annotated, Literal

import pytest
from pydantic import Field, model_validator

from master.errors import ConfigError, Problem
from master.text.fields import (
    Boolean,
    Finite,
    GivenValue,
    Integer,
    Name,
    OrEmpty,
    ParameterValues,
    Section,
    Signal,
    SignalKey,
)
from master.text.scalar import Plain
from master.text.validation import validate, validated
from master.text.yaml_lines import parse_yaml


class Wheel(Section):
    radius: Annotated[Finite, Field(gt=0.0)] = Field(examples=[0.3])
    spokes: Annotated[Integer, Field(ge=0, le=100)] = 32
    spare: Boolean = False
    kind: Literal["front", "rear"] = "front"


class Cart(Section):
    name: Name = Field(examples=["cart"])
    wheels: list[Wheel] = Field([])
    values: ParameterValues = Field({})
    axle: Signal | None = None
    limits: Annotated[dict[SignalKey, Finite], OrEmpty] = Field({})
    label: GivenValue = ""
    low: Finite = 0.0
    high: Finite = 1.0

    @classmethod
    def stand_in(cls, key, data):
        return "cart" if key == "name" else None

    @model_validator(mode="after")
    def _ordered(self):
        if not self.low < self.high:
            raise ValueError(
                f"low is not below high, got {self.low:g} and {self.high:g}, expected low < high"
            )
        return self


def read(text):
    return validate(Cart, parse_yaml(text, Path("cart.yaml")), "cart")


def cart(text):
    return validated(Cart, parse_yaml(text, Path("cart.yaml")), "cart")


def faults(text):
    return [*map(str, read(text).problems)]


def test_numbers_are_of_the_core_schema_and_texts_are_as_written():
    found = cart("name: 010\nwheels: [{radius: 1e-1, spokes: 010}]\nvalues: {a: 1.10, b: yes, c: '3'}\n")

    assert (found.name, found.wheels[0].radius, found.wheels[0].spokes) == ("010", 0.1, 10)
    assert found.values == {"a": "1.10", "b": "yes", "c": "3"}
    assert [type(v) for v in found.values.values()] == [Plain, Plain, str]


def test_nothing_given_is_no_fault():
    found = cart("name: a\nwheels:\nvalues: ~\naxle: null\nlimits:\n")

    assert (found.wheels, found.values, found.axle, found.limits) == ([], {}, None, {})


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        ("low: 1:30", "low: not a number, got '1:30', expected a number"),
        ("low: 1_000", "low: not a number, got '1_000', expected a number"),
        ("low: true", "low: not a number, got true, expected a number"),
        ("low: [1]", "low: not a number, got [1], expected a number"),
        ("low: .nan", "low: not a finite number, got .nan"),
        ("low: 1e400", "low: not a finite number, got 1e400"),
        ("name: [a]", "name: not a text, got ['a'], expected a text"),
        ("name: ../a", "name: not a name of a folder, got '../a', expected one without slashes"),
        ("name: ..", "name: not a name of a folder, got '..', expected one without slashes"),
        (
            'name: "a\\e[0m"',
            "name: a name with control characters, got 'a\\x1b[0m', expected printable ones",
        ),
        ("axle: front", "axle: not an 'instance.variable', got 'front'"),
        ("limits: {a: 1}", "limits.a: not an 'instance.variable', got 'a'"),
        ("limits: {a.b: x}", "limits.a.b: not a number, got 'x', expected a number"),
        ("values: 3", "values: not a mapping, got 3, expected a mapping"),
        (
            "values: {a: {b: 1}}",
            "values.a: not a value, expected a number, a text, or a list of them for an array",
        ),
        (
            "values: {a: }",
            "values.a: no value, got nothing, expected a number or a text ('' for an empty one)",
        ),
        ("wheels: {radius: 1}", "wheels: not a list, got a mapping, expected a list"),
        ("wheels: [3]", "wheels[0]: not a mapping, got 3, expected a mapping"),
        ("wheels: [{}]", "wheels[0].radius: missing, expected a value, for example `radius: 0.3`"),
        ("wheels: [{radius: 0}]", "wheels[0].radius: too small, got 0, expected more than 0"),
        (
            "wheels: [{radius: 1, spokes: 1.5}]",
            "wheels[0].spokes: not an integer, got 1.5, expected an integer",
        ),
        (
            "wheels: [{radius: 1, spokes: 1e30}]",
            "wheels[0].spokes: too large, got 1e30, ",
        ),
        (
            "wheels: [{radius: 1, spare: yes}]",
            "wheels[0].spare: not true or false, got 'yes', ",
        ),
        (
            "wheels: [{radius: 1, kind: left}]",
            "wheels[0].kind: not one of the choices, got 'left', expected 'front' or 'rear'",
        ),
        (
            "wheels: [{radius: 1, spoke: 3}]",
            "wheels[0].spoke: unknown key, got 3, expected 'spokes' (of radius, spokes, spare, kind)",
        ),
        ("wheels: [{radios: 1}]", "wheels[0].radios: unknown key, got 1, expected 'radius' (of radius, "),
        ("low: 2", "file: low is not below high, got 2 and 1, expected low < high"),
    ],
)
def test_a_fault_has_its_line_what_is_wrong_what_is_there_and_what_belongs_there(line, fault):
    text = f"{line}\n" if line.startswith("name") else f"{line}\nname: a\n"

    assert any(found.startswith(f"cart.yaml:1: {fault}") for found in faults(text))


def test_a_fault_of_5000_digits_is_cut():
    [fault] = faults("name: a\nlow: " + "9" * 5000 + "\n")

    assert len(fault) < 300
    assert "5000 digits" in fault


def test_one_unknown_key_hides_no_other_fault():
    text = "nam: a\nwheels:\n  - {radius: -1, spokes: x, colour: red}\n  - {spokes: 3}\n"
    text += "low: fast\nextra: {a: 1}\n"

    assert [fault.split(": ")[1] for fault in faults(text)] == [
        "name",
        "wheels[0].radius",
        "wheels[0].spokes",
        "wheels[0].colour",
        "wheels[1].radius",
        "low",
        "nam",
        "extra",
    ]


def test_what_is_right_is_read_without_what_is_wrong():
    found = read(
        "name: [1]\nwheels:\n  - {radius: -1}\n  - {radius: 2, colour: red}\n  - {radius: 3, spokes: x}\n"
    )

    assert found.model.name == "cart"
    assert [(w.radius, w.spokes) for w in found.model.wheels] == [(2.0, 32), (3.0, 32)]
    assert found.document.where(("wheels", 1, "spokes")) == "cart.yaml:5: wheels[2].spokes"


def test_two_faults_of_one_entry_take_no_other_entry_along():
    found = read("name: a\nwheels:\n  - {radius: 1}\n  - {radius: x, kind: y}\n  - {radius: 3}\n")

    assert [w.radius for w in found.model.wheels] == [1.0, 3.0]


def test_a_rule_of_a_whole_section_is_checked_beside_an_unknown_key():
    assert [fault.split(": ")[1] for fault in faults("name: a\nqqq: 1\nlow: 2\n")] == ["qqq", "file"]


def test_a_rule_is_not_blamed_on_a_value_that_is_left_out():
    assert [fault.split(": ")[1] for fault in faults("name: a\nhigh: x\nlow: 2\n")] == ["high"]


def test_a_file_that_holds_no_mapping_is_refused():
    assert faults("- a\n") == ["cart.yaml:1: file: not a cart, got ['a'], expected a mapping with name, ..."]


def test_an_error_carries_the_parts_of_its_problems():
    with pytest.raises(ConfigError) as caught:
        cart("name: a\nlow: fast\n")

    [problem] = caught.value.problems
    assert problem.as_dict() == {
        "where": "cart.yaml:2: low",
        "what": "not a number",
        "got": "'fast'",
        "expected": "a number",
    }
    assert str(caught.value) == problem


@pytest.mark.parametrize(
    "line",
    [
        "a.yaml:3: fmus.a.every: too small, got 0, expected at least 1",
        "--set a.b: is given twice, expected one value",
        "wheels[0].radius: missing, expected a value",
        "a: b.yaml:3: c: no such file, got 'x'",
        "does nothing",
    ],
)
def test_a_line_keeps_its_text_when_it_is_split(line):
    problem = Problem.of_line(line)

    assert problem == line
    assert Problem.of_line(problem) is problem
    assert problem.at("x:1: y") == f"x:1: y: {line}"
