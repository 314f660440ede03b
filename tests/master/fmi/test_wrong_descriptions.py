"""Descriptions with faults: each is told with the element where it is, all of a file at once."""

import random
import re
from contextlib import suppress

import pytest

from master.errors import ConfigError
from master.fmi.description_reader import read_description
from tests.stubs.descriptions import XML, XML_3, archive

U, Y = "ModelVariables/ScalarVariable 'u'", "ModelVariables/Float64 'y'"


def faults(folder, xml):
    path = archive(folder, xml)
    with pytest.raises(ConfigError) as caught:
        read_description(path)
    return [p.removeprefix(f"{path}: modelDescription.xml: ") for p in caught.value.problems]


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ('name="u" ', 'name="T" ', "ModelVariables/ScalarVariable 'T': name: 'T' is there twice"),
        ('name="u" ', "", "ModelVariables/ScalarVariable 'number 1': name: missing, expected a text"),
        ('Reference="0"', 'Reference="-1"', f"{U}: valueReference: got '-1', expected an integer from 0 to "),
        ('valueReference="0" ', "", f"{U}: valueReference: missing, expected an integer from 0 to "),
        (
            'Reference="0"',
            'Reference="1.0"',
            f"{U}: valueReference: got '1.0', expected an integer from 0 to ",
        ),
        ('min="0"', 'min=""', f"{U}: min: got '', expected a number"),
        ('nominal="2"', 'nominal="2,5"', f"{U}: nominal: got '2,5', expected a number"),
        ('causality="input" d', 'causality="imput" d', f"{U}: causality: got 'imput', expected one of "),
        (
            'causality="input" d',
            'causality="input" variability="fixed" d',
            f"{U}: variability: got 'fixed' with causality input, expected",
        ),
        (
            'causality="input" d',
            'causality="input" initial="first" d',
            f"{U}: initial: got 'first', expected one of exact",
        ),
        (
            '<Real start="1.5" unit="mm" min="0" max="9" nominal="2"/>',
            "",
            f"{U}: no type, expected a ScalarVariable with one of ",
        ),
        (
            "<Integer/>",
            "<Int32/>",
            "ModelVariables/ScalarVariable 'n': no type, expected a ScalarVariable with one of ",
        ),
        (
            'declaredType="Length"',
            'declaredType="Width"',
            "ModelVariables/ScalarVariable 'x': declaredType: got 'Width', which is not",
        ),
        (
            'declaredType="Length"',
            'declaredType="Method"',
            "ModelVariables/ScalarVariable 'x': declaredType: got 'Method', which is a Enumeration",
        ),
        (
            'name="rls" value="2"',
            'name="rls" value="b"',
            "TypeDefinitions 'Method': Item 'rls': value: got 'b', expected an integer",
        ),
        (
            'dependencies="1"',
            'dependencies="99"',
            "ModelStructure/Outputs/Unknown number 1: dependencies: got '99', expected from 1 to 9",
        ),
        (
            '<Unknown index="4"/>',
            "<Unknown/>",
            "ModelStructure/Outputs/Unknown number 2: index: missing, expected an integer",
        ),
        (
            'index="4"',
            'index="0"',
            "ModelStructure/Outputs/Unknown number 2: index: got 0, expected from 1 to 9",
        ),
        ('m="1" factor', 'm="half" factor', "UnitDefinitions/Unit 'mm': m: got 'half', expected an integer"),
        (
            'canGetAndSetFMUstate="true"',
            'canGetAndSetFMUstate="maybe"',
            "CoSimulation: canGetAndSetFMUstate: got 'maybe', expected true or false",
        ),
        (
            'modelIdentifier="rope"',
            'modelIdentifier="../rope"',
            "CoSimulation: modelIdentifier: got '../rope', expected a file name",
        ),
        ('modelIdentifier="rope" ', "", "CoSimulation: modelIdentifier: got 'none', expected a file name"),
    ],
)
def test_a_fault_of_fmi_2_is_told_with_its_element(tmp_path, old, new, fault):
    assert old in XML
    [found] = faults(tmp_path, XML.replace(old, new, 1))
    assert found.startswith(fault)


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("<Boolean ", "<Bool ", "ModelVariables/Bool 'on': unknown element, expected one of Float64, "),
        ('start="1 2"', 'start="1 2 3"', "ModelVariables/Float64 'u': start: got 3 values, expected 2"),
        ('start="1 2"', 'start=" "', "ModelVariables/Float64 'u': start: got ' ', expected a value"),
        (
            '<Dimension start="2"/>',
            '<Dimension start="-2"/>',
            "ModelVariables/Float64 'u'/Dimension: start: got '-2', expected an integer from 0",
        ),
        (
            '<Dimension start="2"/>',
            '<Dimension start="99999999999"/>',
            "ModelVariables/Float64 'u': Dimension: got 99999999999 elements, expected at most",
        ),
        (
            '<Dimension valueReference="3"/>',
            "<Dimension/>",
            "ModelVariables/Float32 'z'/Dimension: start: missing",
        ),
        (
            '<Dimension valueReference="3"/>',
            '<Dimension valueReference="2"/>',
            "ModelVariables/Float32 'z'/Dimension: valueReference: got 2, expected",
        ),
        ('declaredType="Force"', 'declaredType="Forces"', f"{Y}: declaredType: got 'Forces', which is not"),
        ('min="0"', 'min="zero"', f"{Y}: min: got 'zero', expected a number"),
        (
            'Output valueReference="2"',
            'Output valueReference="7"',
            "ModelStructure/Output number 1: valueReference: got 7, expected the reference of",
        ),
        (
            'start="true"',
            'start="TRUE"',
            "ModelVariables/Boolean 'on': start: got 'TRUE', expected a value of type Boolean",
        ),
        (
            'start="true"',
            'start="true true"',
            "ModelVariables/Boolean 'on': start: got 2 values, expected one",
        ),
        ('instantiationToken="{1}"', "", "fmiModelDescription: instantiationToken: missing, expected a text"),
        (
            '<Boolean name="on" valueReference="5" causality="parameter" start="true"/>',
            '<Boolean name="on" valueReference="5"><Alias/></Boolean>',
            "ModelVariables/Boolean 'on': Alias: name: missing, expected a text",
        ),
        ('name="on"', 'name="u[2]"', "ModelVariables/Boolean 'u[2]': name: 'u[2]' is there twice"),
    ],
)
def test_a_fault_of_fmi_3_is_told_with_its_element(tmp_path, old, new, fault):
    assert old in XML_3
    [found] = faults(tmp_path, XML_3.replace(old, new, 1))
    assert found.startswith(fault)


def test_all_faults_of_a_file_are_told_at_once_up_to_thirty(tmp_path):
    found = faults(tmp_path, XML.replace('min="0"', 'min=""').replace('start="20"', 'start="warm"'))
    assert [f.partition(":")[0] for f in found] == [U, "ModelVariables/ScalarVariable 'T'"]

    many = "".join(f'<ScalarVariable name="v{i}"><Real/></ScalarVariable>' for i in range(100))
    found = faults(tmp_path, XML.replace("<ModelVariables>", f"<ModelVariables>{many}", 1))
    assert len(found) == 31
    assert found[-1] == "70 more faults"


def test_a_description_without_variables_is_refused(tmp_path):
    xml = re.sub("(?s)<ModelVariables>.*</ModelVariables>", "<ModelVariables/>", XML)
    assert faults(tmp_path, xml)[0] == "ModelVariables: got none, expected at least one variable"


@pytest.mark.parametrize("version", ["2.1", "3.1", "3", "2", "three", "30.0"])
def test_another_version_is_refused(tmp_path, version):
    xml = XML.replace('fmiVersion="2.0"', f'fmiVersion="{version}"')
    assert faults(tmp_path, xml)[0].endswith(
        f"FMI version not supported, got {version!r}, expected 2.0 or 3.0"
    )


@pytest.mark.parametrize("version", ["3.0", "3.0.2", "3.0-beta.5"])
def test_editions_of_fmi_3_are_read(tmp_path, version):
    assert read_description(archive(tmp_path, XML_3.replace("3.0", version, 1))).version == 3


def test_an_fmu_for_scheduled_execution_only_is_refused_by_that_name(tmp_path):
    xml = XML_3.replace("<CoSimulation ", "<ScheduledExecution ")
    assert faults(tmp_path, xml)[0].endswith("got an FMU for scheduled execution only")


@pytest.mark.parametrize("text", [XML, XML_3], ids=["2.0", "3.0"])
def test_whatever_is_changed_the_description_is_read_or_refused(tmp_path, text):
    words = [
        "",
        "-1",
        "99",
        "1e400",
        "nan",
        "2.5",
        "true",
        "x",
        "9" * 500,
        "\u00b2",
        "fixed",
        "constant",
        "N",
    ]
    draw = random.Random(7)
    places = [m.span(1) for m in re.finditer(r'="([^"]*)"', text)]
    for i in range(600):
        changed = text
        for start, end in sorted(draw.sample(places, draw.randint(1, 3)), reverse=True):
            changed = changed[:start] + draw.choice(words) + changed[end:]
        if draw.random() < 0.3:
            at = draw.randrange(len(text))
            changed = changed[:at] + changed[at + draw.randint(1, 40) :]
        path = archive(tmp_path, changed)
        with suppress(ConfigError):  # any other error fails the test
            read_description(path.rename(tmp_path / f"{i}.fmu"))


@pytest.mark.parametrize(
    ("declared", "fault"),
    [
        (
            '<Linear parameter="metod" value="rls"/>',
            "Coupling/Linear of 'metod': no such variable, got 'metod', expected 'method'",
        ),
        (
            '<Linear parameter="method" value="fixed"/>',
            "Coupling/Linear of 'method': value not allowed for method, got 'fixed', expected ",
        ),
        (
            '<Linear parameter="u" value="0" frequency="f"/>',
            "Coupling/Linear of 'u': frequency: no such variable, got 'f', expected ",
        ),
        (
            '<Learning by="method" item="rls" held="method"/>',
            "Coupling/Learning by 'method': held: value not allowed for method, got 'true', expected ",
        ),
        (
            '<Learning by="label" item="rls" held="on"/>',
            "Coupling/Learning by 'label': no such variable, got 'label', expected ",
        ),
    ],
)
def test_what_an_fmu_declares_of_its_linearity_must_exist(tmp_path, declared, fault):
    annotation = (
        f'<VendorAnnotations><Tool name="x"><Coupling>{declared}</Coupling></Tool></VendorAnnotations>'
    )
    [found] = faults(tmp_path, XML.replace("<ModelVariables>", f"{annotation}<ModelVariables>", 1))
    assert found.startswith(fault)
