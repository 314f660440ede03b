"""What a variable has from its declared type where it has none of its own."""

import pytest

from master.fmi.description_reader import read_description
from master.fmi.values import alias_notes, parse, start_notes
from tests.stubs.descriptions import archive

TYPES_2 = """
  <SimpleType name="T">
    <Real quantity="Temp" unit="degC" displayUnit="degF" min="-10" max="10" nominal="5"/></SimpleType>
  <SimpleType name="Difference"><Real unit="degC" relativeQuantity="true"/></SimpleType>
  <SimpleType name="Count"><Integer min="1" max="3"/></SimpleType>
  <SimpleType name="Gear"><Enumeration>
    <Item name="low" value="1"/><Item name="high" value="4"/></Enumeration></SimpleType>
"""
TYPES_3 = """
  <Float64Type name="T" quantity="Temp" unit="degC" displayUnit="degF" min="-10" max="10" nominal="5"/>
  <Float64Type name="Difference" unit="degC" relativeQuantity="true"/>
  <Int32Type name="Count" min="1" max="3"/>
  <EnumerationType name="Gear"><Item name="low" value="1"/><Item name="high" value="4"/></EnumerationType>
"""
VARIABLES = {
    "plain": ("T", 'declaredType="T"'),
    "own": ("T", 'declaredType="T" unit="K" displayUnit="K" min="0" max="99" nominal="1" quantity="Q"'),
    "step": ("T", 'declaredType="Difference"'),
    "absolute": ("T", 'declaredType="Difference" relativeQuantity="false"'),
    "count": ("Count", 'declaredType="Count"'),
    "narrow": ("Count", 'declaredType="Count" max="2"'),
    "gear": ("Gear", 'declaredType="Gear"'),
}
NAMES = {
    "2.0": {"T": "Real", "Count": "Integer", "Gear": "Enumeration"},
    "3.0": {"T": "Float64", "Count": "Int32", "Gear": "Enumeration"},
}


def described(folder, version, starts=None):
    variables = ""
    for i, (name, (kind, attributes)) in enumerate(VARIABLES.items()):
        start = (starts or {}).get(name)
        more = attributes + ("" if start is None else f' start="{start}"')
        common = f'name="{name}" valueReference="{i}" causality="parameter" variability="fixed"'
        tag = NAMES[version][kind]
        variables += (
            f"<{tag} {common} {more}/>"
            if version == "3.0"
            else f"<ScalarVariable {common}><{tag} {more}/></ScalarVariable>"
        )
    token = "guid" if version == "2.0" else "instantiationToken"
    return read_description(
        archive(
            folder,
            f"""<fmiModelDescription fmiVersion="{version}" modelName="m" {token}="1">
            <CoSimulation modelIdentifier="m"/>
            <UnitDefinitions><Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>
            <Unit name="K"><BaseUnit K="1"/></Unit></UnitDefinitions>
            <TypeDefinitions>{TYPES_2 if version == "2.0" else TYPES_3}</TypeDefinitions>
            <ModelVariables>{variables}</ModelVariables><ModelStructure/></fmiModelDescription>""",
        )
    )


VERSIONS = pytest.mark.parametrize("version", ["2.0", "3.0"])


@VERSIONS
def test_a_variable_has_all_of_its_type_and_its_own_counts_more(tmp_path, version):
    found = described(tmp_path, version).by_name

    def attributes(v):
        return (v.quantity, v.unit_name, v.display_unit, v.minimum, v.maximum, v.nominal)

    assert attributes(found["plain"]) == ("Temp", "degC", "degF", -10.0, 10.0, 5.0)
    assert attributes(found["own"]) == ("Q", "K", "K", 0.0, 99.0, 1.0)
    assert (found["narrow"].minimum, found["narrow"].maximum) == (1, 2)
    assert found["gear"].items == {"low": 1, "high": 4}


@VERSIONS
def test_a_difference_by_its_type_has_none_of_the_offset(tmp_path, version):
    found = described(tmp_path, version).by_name

    assert [found[n].unit.offset for n in ("plain", "step", "absolute")] == [273.15, 0.0, 273.15]


@VERSIONS
@pytest.mark.parametrize(
    ("name", "value", "fault"),
    [
        ("plain", 11, "expected at most 10"),
        ("count", 0, "expected at least 1"),
        ("narrow", 3, "expected at most 2"),
        ("gear", 2, "expected one of low, high"),
    ],
)
def test_a_value_outside_the_bounds_of_the_type_is_refused(tmp_path, version, name, value, fault):
    with pytest.raises(ValueError, match=fault):
        parse(described(tmp_path, version).by_name[name], value)


@VERSIONS
def test_start_values_of_the_fmu_that_break_its_own_rules_are_noted(tmp_path, version):
    starts = {"plain": "NaN", "own": "-1", "count": "7", "gear": "2", "step": "1"}
    description = described(tmp_path, version, starts)
    end = "it is left as it is"

    assert start_notes(description, ()) == [
        f"plain: the FMU's own start value is nan degC, expected a finite number; {end}",
        f"own: the FMU's own start value is -1 K, expected at least 0; {end}",
        f"count: the FMU's own start value is 7, expected at most 3; {end}",
        f"gear: the FMU's own start value is 2, expected one of low, high; {end}",
    ]
    assert len(start_notes(description, {"plain", "own", "count"})) == 1


def test_aliases_of_different_units_are_noted(tmp_path):
    text = """<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g">
      <CoSimulation modelIdentifier="m"/>
      <UnitDefinitions>
        <Unit name="m"><BaseUnit m="1"/></Unit><Unit name="mm"><BaseUnit m="1" factor="0.001"/></Unit>
      </UnitDefinitions>
      <ModelVariables>
        <ScalarVariable name="a" valueReference="1" causality="output"><Real unit="m"/></ScalarVariable>
        <ScalarVariable name="b" valueReference="1" causality="output"><Real unit="mm"/></ScalarVariable>
        <ScalarVariable name="c" valueReference="1" causality="output"><Real unit="m"/></ScalarVariable>
      </ModelVariables><ModelStructure/></fmiModelDescription>"""
    (tmp_path / "modelDescription.xml").write_text(text)

    assert alias_notes(read_description(tmp_path)) == [
        "b: shares a value with a, got the units mm and m, expected one"
    ]
