import pytest

from master.errors import ConfigError
from master.fmi.description import Kind
from master.fmi.description_reader import read_description
from master.fmi.value_types import FLOAT64, INT32, INT_BOOLEAN
from tests.conftest import PROJECT
from tests.stubs.descriptions import XML, archive

U = "ModelVariables/ScalarVariable 'u'"


@pytest.fixture
def rope(tmp_path):
    return read_description(archive(tmp_path, XML))


def fault(path):
    with pytest.raises(ConfigError) as caught:
        read_description(path)
    [problem] = caught.value.problems
    return problem.replace(f"{path.parent}/", "")


def test_name_version_and_abilities_are_read(rope):
    assert (rope.model_name, rope.model_identifier, rope.token) == ("Rope", "rope", "{1}")
    assert (rope.version, rope.can_get_and_set_state, rope.needs_execution_tool) == (2, True, False)


def test_a_variable_has_type_start_range_and_description(rope):
    u = rope.by_name["u"]

    assert (u.reference, u.kind, u.value_type, u.start) == (0, Kind.REAL, FLOAT64, "1.5")
    assert (u.minimum, u.maximum, u.nominal, u.description) == (0.0, 9.0, 2.0, "pull")


def test_units_have_factor_offset_and_exponents(rope):
    mm, celsius = rope.by_name["u"].unit, rope.by_name["T"].unit

    assert (mm.name, mm.factor, mm.exponents) == ("mm", 0.001, {"m": 1})
    assert (celsius.offset, celsius.exponents) == (273.15, {"K": 1})


def test_a_declared_type_gives_its_unit(rope):
    assert rope.by_name["x"].unit_name == "mm"


def test_a_unit_that_is_named_only_is_not_defined(rope):
    assert not rope.by_name["y"].unit.defined
    assert rope.by_name["n"].unit_name == "1"


def test_the_kinds_have_the_types_of_the_c_interface(rope):
    found = {n: (rope.by_name[n].kind, rope.by_name[n].value_type) for n in ("n", "on", "method")}

    assert found == {
        "n": (Kind.INTEGER, INT32),
        "on": (Kind.BOOLEAN, INT_BOOLEAN),
        "method": (Kind.INTEGER, INT32),
    }


def test_an_enumeration_has_its_items(rope):
    assert rope.by_name["method"].items == {"kalman": 1, "rls": 2}


def test_recorded_outputs_are_numbers_in_declared_order(rope):
    assert [v.name for v in rope.outputs] == ["x", "y", "n"]
    assert "time" not in rope.by_name


def test_a_relative_quantity_has_none_of_its_unit_s_offset(tmp_path):
    text = XML.replace('unit="degC"', 'unit="degC" relativeQuantity="true"')
    text = text.replace('<Real unit="mm"/>', '<Real unit="degC" relativeQuantity="true"/>')
    description = read_description(archive(tmp_path, text))

    assert [description.by_name[name].unit.offset for name in "Tx"] == [0.0, 0.0]
    assert description.by_name["x"].unit.name == "degC"


def test_an_output_that_the_structure_does_not_list_hangs_on_all_inputs(tmp_path):
    text = XML.replace('<Unknown index="3" dependencies="1"/>', "")

    assert read_description(archive(tmp_path, text)).feedthrough["x"] == ("u", "T")


def test_an_output_without_dependencies_hangs_on_all_inputs(rope):
    assert rope.feedthrough["x"] == ("u",)
    assert rope.feedthrough["y"] == ("u", "T")
    assert rope.feedthrough["n"] == ()


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('start="1.5"', 'start="1,5"', f"{U}: start: got '1,5', expected a value of type Real"),
        (
            'start="true"',
            'start="yes"',
            "ModelVariables/ScalarVariable 'on': start: got 'yes', expected a value of type Boolean",
        ),
        (
            'factor="0.001"',
            'factor="0"',
            "UnitDefinitions/Unit 'mm': cannot be converted, got factor 0 and offset 0, "
            "expected finite numbers and a factor that is not zero",
        ),
        ('guid="{1}"', "", "fmiModelDescription: guid: missing, expected a text"),
        ('min="0"', 'min="low"', f"{U}: min: got 'low', expected a number"),
    ],
)
def test_a_description_with_a_value_that_cannot_be_is_refused(tmp_path, old, new, problem):
    assert fault(archive(tmp_path, XML.replace(old, new))) == (f"rope.fmu: modelDescription.xml: {problem}")


def test_a_missing_file_is_refused(tmp_path):
    assert fault(tmp_path / "none.fmu") == "none.fmu: no such file, expected an FMU"


def test_a_file_that_is_no_archive_is_refused(tmp_path):
    path = tmp_path / "rope.fmu"
    path.write_text("text", encoding="utf-8")

    assert fault(path) == "rope.fmu: not an FMU, expected a zip archive with modelDescription.xml"


def test_an_archive_without_a_description_is_refused(tmp_path):
    path = archive(tmp_path, "", name="other.xml")

    assert fault(path) == "rope.fmu: not an FMU, expected modelDescription.xml in the archive"


def test_a_description_that_is_not_xml_is_refused(tmp_path):
    assert fault(archive(tmp_path, "<a>")).startswith("rope.fmu: modelDescription.xml is not XML: ")


@pytest.mark.parametrize(("version", "shown"), [("1.0", "1.0"), ("", "none"), ("4.0", "4.0")])
def test_another_version_of_fmi_is_refused(tmp_path, version, shown):
    path = archive(tmp_path, XML.replace('fmiVersion="2.0"', f'fmiVersion="{version}"'))

    assert fault(path) == f"rope.fmu: FMI version not supported, got {shown!r}, expected 2.0 or 3.0"


def test_an_fmu_for_model_exchange_only_is_refused(tmp_path):
    xml = XML.replace(
        '<CoSimulation modelIdentifier="rope" canGetAndSetFMUstate="true"/>',
        '<ModelExchange modelIdentifier="rope"/>',
    )

    assert fault(archive(tmp_path, xml)) == (
        "rope.fmu: not for co-simulation, got an FMU for model exchange only"
    )


def test_a_description_that_breaks_the_standard_is_refused(tmp_path):
    path = archive(tmp_path, XML.replace('<Unknown index="3"', '<Unknown index="99"'))

    assert fault(path) == (
        "rope.fmu: modelDescription.xml: ModelStructure/Outputs/Unknown number 1: index: got 99, "
        "expected from 1 to 9, the number of variables"
    )


def test_only_native_fmus_of_this_project_are_trusted_with_the_floating_point_mode(rope):
    released = [*(PROJECT / "fmus").glob("*.fmu"), *(PROJECT / "fmus" / "fmi3").glob("*.fmu")]
    own = [read_description(path).keeps_float_mode for path in released]

    assert own
    assert all(own)
    assert not rope.keeps_float_mode
