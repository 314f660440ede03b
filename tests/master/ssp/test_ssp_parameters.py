"""Values of SSP: where they are given, what they become, which of several counts, what is refused."""

import pytest

from master.errors import ConfigError
from master.experiment.prepare import prepare
from tests.master.ssp.ssp_archives import (
    NAMESPACES,
    binding,
    bindings,
    component,
    connector,
    connectors,
    entry,
    fmu,
    link,
    links,
    mapping,
    packed,
    parameter,
    parameter_set,
    structure,
    system,
    write,
)

SPACES = NAMESPACES
KILO = '<ssv:Units><ssc:Unit name="km"><ssc:BaseUnit m="1" factor="1000"/></ssc:Unit></ssv:Units>'
DEGREES = '<ssv:Units><ssc:Unit name="degC"><ssc:BaseUnit K="1" offset="273.15"/></ssc:Unit></ssv:Units>'
GEARS = (
    '<ssv:Enumerations><ssc:Enumeration name="gear"><ssc:Item name="slow" value="1"/>'
    '<ssc:Item name="fast" value="2"/></ssc:Enumeration></ssv:Enumerations>'
)


def one(*content, files=None, folder):
    """The box called a, with these bindings."""
    return write(folder, system(component("a", bindings(*content))), files)


def start(path, name="a"):
    return dict(prepare(path).system.instances[name].start)


def faults(path):
    with pytest.raises(ConfigError) as caught:
        prepare(path)
    return "\n".join(caught.value.problems)


@pytest.mark.parametrize(
    ("name", "type_", "value", "more", "given", "expected"),
    [
        ("p", "Real", "1.5e-3", "", "", 1.5e-3),
        ("p", "Real", " 2 ", "", "", 2.0),
        ("p", "Integer", "3", "", "", 3.0),
        ("p", "Real", "2", 'unit="km"', KILO, 2000.0),
        ("p", "Real", "2", 'unit="mm"', "", 0.002),  # the structure around it defines mm
        ("temperature", "Real", "20", 'unit="degC"', DEGREES, 293.15),
        ("n", "Integer", "-7", "", "", -7.0),
        ("n", "Enumeration", "fast", 'name="gear"', GEARS, 2.0),
        ("on", "Boolean", "true", "", "", 1.0),
        ("on", "Boolean", "1", "", "", 1.0),
        ("on", "Boolean", "0", "", "", 0.0),
        ("mode", "Enumeration", "fast", "", "", 2.0),
        ("mode", "Enumeration", "2", "", "", 2.0),
        ("mode", "Integer", "2", "", "", 2.0),
        ("label", "String", "010", "", "", "010"),
        ("label", "String", "", "", "", ""),
    ],
)
def test_a_value_becomes(tmp_path, name, type_, value, more, given, expected):
    inside = parameter_set(parameter(name, type_, value, more), more=given)

    assert start(one(binding(inside), folder=tmp_path)) == {name: expected}


@pytest.mark.parametrize(
    ("source", "inner", "attributes", "name", "expected"),
    [
        (parameter("x", "Real", "2"), "", "", "p", 2.0),
        (parameter("x", "Real", "2"), '<ssc:LinearTransformation factor="3" offset="1"/>', "", "p", 7.0),
        (
            parameter("x", "Real", "2", 'unit="km"'),
            '<ssc:LinearTransformation factor="3" offset="1"/>',
            "",
            "p",
            6001.0,
        ),
        (
            parameter("x", "Real", "2", 'unit="km"'),
            '<ssc:LinearTransformation factor="3" offset="1"/>',
            'suppressUnitConversion="true"',
            "p",
            7.0,
        ),
        (
            parameter("x", "Boolean", "true"),
            '<ssc:BooleanMappingTransformation><ssc:MapEntry source="1" target="0"/></ssc:BooleanMappingTransformation>',
            "",
            "on",
            0.0,
        ),
        (
            parameter("x", "Integer", "4"),
            '<ssc:IntegerMappingTransformation><ssc:MapEntry source="4" target="9"/></ssc:IntegerMappingTransformation>',
            "",
            "n",
            9.0,
        ),
        (
            parameter("x", "Integer", "5"),
            '<ssc:IntegerMappingTransformation><ssc:MapEntry source="4" target="9"/></ssc:IntegerMappingTransformation>',
            "",
            "n",
            5.0,
        ),
        (
            parameter("x", "Enumeration", "snail"),
            '<ssc:EnumerationMappingTransformation><ssc:MapEntry source="snail" target="fast"/>'
            "</ssc:EnumerationMappingTransformation>",
            "",
            "mode",
            2.0,
        ),
        (
            parameter("x", "Enumeration", "slow"),
            '<ssc:EnumerationMappingTransformation><ssc:MapEntry source="snail" target="fast"/>'
            "</ssc:EnumerationMappingTransformation>",
            "",
            "mode",
            1.0,
        ),
    ],
)
def test_a_mapping_renames_and_transforms(tmp_path, source, inner, attributes, name, expected):
    renaming = mapping(entry("x", name, inner, attributes))
    path = one(binding(parameter_set(source, more=KILO), renaming), folder=tmp_path)

    assert start(path) == {name: expected}


def test_with_a_mapping_only_what_it_names_is_used(tmp_path):
    values = parameter_set(parameter("x", "Real", "2"), parameter("n", "Integer", "3"))
    path = one(binding(values, mapping(entry("x", "p"), entry("z", "n"))), folder=tmp_path)

    assert start(path) == {"p": 2.0}
    notes = "\n".join(prepare(path).notes)
    assert "not in the mapping and so not used: n" in notes
    assert "no such value in the parameter set: z" in notes


def test_values_and_mapping_come_from_files(tmp_path):
    files = {
        "resources/my values.ssv": parameter_set(parameter("x", "Real", "2"), namespaces=SPACES),
        "maps/m.ssm": mapping(entry("x", "p"), namespaces=SPACES),
    }
    inner = '<ssd:ParameterMapping source="file:maps/m.ssm"/>'
    given = f'<ssd:ParameterBinding source="resources\\my%20values.ssv">{inner}</ssd:ParameterBinding>'

    assert start(one(given, files=files, folder=tmp_path)) == {"p": 2.0}


def test_values_come_from_inside_the_component(tmp_path):
    inside = packed(
        {
            "modelDescription.xml": _description(),
            "extra/p.ssv": parameter_set(parameter("p", "Real", "4"), namespaces=SPACES),
        }
    )
    given = binding(attributes='source="extra/p.ssv" sourceBase="component"')

    assert start(one(given, files={"resources/box.fmu": inside}, folder=tmp_path)) == {"p": 4.0}


def _description():
    import io
    import zipfile

    return zipfile.ZipFile(io.BytesIO(fmu())).read("modelDescription.xml")


def values(name, value):
    return binding(parameter_set(parameter(name, "Real", str(value))))


def test_the_later_of_two_bindings_counts(tmp_path):
    assert start(one(values("p", 1), values("p", 2), folder=tmp_path)) == {"p": 2.0}


def nested(outer="", sub="", inner="", before=""):
    g = component("g", inner)
    content = system(g, before=before + sub, name="sub")
    return system(content, before=outer)


@pytest.mark.parametrize(
    ("outer", "sub", "inner", "expected"),
    [
        ("", "", bindings(values("p", 1)), 1.0),
        ("", bindings(values("g.p", 2)), bindings(values("p", 1)), 2.0),
        (bindings(values("sub.g.p", 3)), bindings(values("g.p", 2)), bindings(values("p", 1)), 3.0),
    ],
)
def test_an_outer_binding_counts_more_than_an_inner_one(tmp_path, outer, sub, inner, expected):
    assert start(write(tmp_path, nested(outer, sub, inner)), "sub/g") == {"p": expected}


@pytest.mark.parametrize("renaming", ["", mapping(entry("sub.g.p", "sub.g.temperature"))])
def test_a_prefix_comes_before_names_and_mappings(tmp_path, renaming):
    given = binding(parameter_set(parameter("p", "Real", "3")), renaming, 'prefix="sub.g."')
    path = write(tmp_path, nested(outer=bindings(given)))

    assert start(path, "sub/g") == {"temperature" if renaming else "p": 3.0}


def test_a_name_with_dots_reaches_all_that_it_may_mean(tmp_path):
    content = system(system(component("c"), name="b"), component("b.c"), before=bindings(values("b.c.p", 2)))
    path = write(tmp_path, content)

    assert start(path, "b/c") == {"p": 2.0}
    assert start(path, "b-c") == {"p": 2.0}
    assert "'b.c' is called 'b-c' here" in "\n".join(prepare(path).notes)


LINEAR = '<ssc:LinearTransformation factor="2" offset="1"/>'


def test_a_value_of_a_system_connector_goes_through_its_connections(tmp_path):
    ports = connectors(connector("u", "input", "Real", "km"), connector("q", "parameter"))
    inner = system(
        component("g"), before=ports, after=links(link(".u", "g.u", LINEAR), link(".q", "g.p")), name="sub"
    )
    root = connectors(connector("in", "input", "Real", "km"))
    given = bindings(
        binding(parameter_set(parameter("in", "Real", "3"), parameter("sub.q", "Real", "5", 'unit="mm"')))
    )
    path = write(tmp_path, system(inner, before=root + given, after=links(link(".in", "sub.u"))))

    assert start(path, "sub/g") == {"u": 6001.0, "p": 0.005}
    assert "inputs of the system: root.in -> sub/g.u" in prepare(path).notes


def test_the_connection_counts_where_a_connected_input_has_a_value(tmp_path):
    content = system(
        component("a"), component("b", bindings(values("u", 9))), after=links(link("a.y", "b.u"))
    )
    path = write(tmp_path, content)

    assert start(path, "b") == {}
    assert "b.u is connected and takes the value of a.y from the start on" in "\n".join(prepare(path).notes)


def test_a_connector_without_a_value_leaves_that_of_the_component(tmp_path):
    root = connectors(connector("in", "input"))
    content = system(component("a", bindings(values("u", 9))), before=root, after=links(link(".in", "a.u")))

    assert start(write(tmp_path, content)) == {"u": 9.0}


def test_a_value_that_nothing_takes_is_a_note(tmp_path):
    path = one(binding(parameter_set(parameter("typo", "Real", "1"))), folder=tmp_path)

    assert start(path) == {}
    assert "ParameterBinding: no variable takes these values: typo" in "\n".join(prepare(path).notes)


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        (parameter("p", "Real", "1,5"), "Parameter 'p': not a Real, got '1,5', expected a number"),
        (parameter("p", "Real", "1_0"), "not a Real"),
        (parameter("p", "Real", "0x10"), "not a Real"),
        (parameter("p", "Real", "NaN"), "expected a finite number"),
        (parameter("p", "Real", "INF"), "expected a finite number"),
        (parameter("p", "Real", "1", 'unit="km"'), ""),
        (parameter("p", "Real", "1", 'unit="N"'), "units differ, got N -> m"),
        (parameter("p", "Real", "1", 'unit="ell"'), "units differ, got ell -> m"),
        (parameter("n", "Integer", "1.0"), "not an Integer, got '1.0', expected an integer"),
        (parameter("n", "Integer", "3000000000"), "expected an integer from -2147483648 to 2147483647"),
        (parameter("n", "Real", "1.5"), "value not allowed, got 1.5, expected an integer"),
        (parameter("on", "Boolean", "yes"), "not a Boolean, got 'yes', expected true or false"),
        (parameter("on", "Real", "1"), "types differ, got Real, expected Boolean"),
        (parameter("p", "Boolean", "1"), "types differ, got Boolean, expected Real"),
        (parameter("label", "Real", "1"), "types differ, got Real, expected String"),
        (parameter("mode", "Enumeration", "reverse"), "got 'reverse'"),
        (parameter("mode", "Integer", "3"), "expected one of slow, fast"),
        (parameter("y", "Real", "1"), "calculated by the FMU"),
        (parameter("p", "Binary", "ff"), "a value of type Binary is not understood"),
        (parameter("p", "Real", "1") * 2, "twice in the parameter set, expected one value of a name"),
        (parameter("p", "Complex", "1"), "Complex: not understood in ssv:Parameter"),
        (parameter("p", "Real", "1", 'quality="good"'), "quality is not understood, got 'good'"),
        ('<ssv:Parameter name="p"/>', "has 0 values, expected one"),
        ('<ssv:Parameter name="p"><ssv:Real/></ssv:Parameter>', "value is missing, expected a value"),
    ],
)
def test_a_value_is_refused_by_name(tmp_path, parameters, said):
    path = one(binding(parameter_set(parameters)), folder=tmp_path)
    if not said:
        assert start(path) == {"p": 1000.0}
        return
    found = faults(path)

    assert said in found
    assert "s.ssp: SystemStructure.ssd:3: " in found


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (binding(), "got neither, expected a source or its content inside"),
        (binding(parameter_set(), attributes='source="x.ssv"'), "got both, expected a source or its content"),
        (binding(attributes='source="resources/nix.ssv"'), "no such file, got 'resources/nix.ssv'"),
        (binding(attributes='source="../out.ssv"'), "outside the archive, got '../out.ssv'"),
        (binding(attributes='source="/etc/passwd"'), "outside the archive, got '/etc/passwd'"),
        (binding(attributes='source="file:///etc/passwd"'), "outside the archive"),
        (binding(attributes='source="https://example.org/p.ssv"'), "outside the archive"),
        (binding(attributes='source="C:\\p.ssv"'), "outside the archive"),
        (binding(attributes='source="resources/box.fmu"'), "not XML"),
        (binding(parameter_set(), attributes='type="text/csv"'), "type is not understood, got 'text/csv'"),
        (binding(attributes='source="n.ssv" sourceBase="component"'), "no such file, got 'n.ssv'"),
        (
            binding(parameter_set(parameter("x", "Real", "1")), mapping(entry("x", "p"), entry("x", "p"))),
            "'p' is a target twice",
        ),
        (
            binding(parameter_set(parameter("x", "Integer", "1")), mapping(entry("x", "n", LINEAR))),
            "LinearTransformation is for Real alone, got Integer",
        ),
    ],
)
def test_a_binding_is_refused_by_name(tmp_path, given, said):
    assert said in faults(one(given, folder=tmp_path))


def test_an_array_gets_its_elements(tmp_path):
    text = (
        '<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="t">'
        '<CoSimulation modelIdentifier="m"/><ModelVariables>'
        '<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>'
        '<Float64 name="v" valueReference="1" causality="parameter" variability="fixed" start="0 0 0">'
        '<Dimension start="3"/></Float64></ModelVariables><ModelStructure/></fmiModelDescription>'
    )
    files = {"resources/array.fmu": packed({"modelDescription.xml": text})}
    three = '<ssv:Parameter name="v"><ssv:Float64 value="1 2 3"/><ssc:Dimension size="3"/></ssv:Parameter>'
    a = component("a", bindings(binding(parameter_set(three))), ports=(), source="resources/array.fmu")
    path = write(tmp_path, structure(system(a), version="2.0"), files)

    assert start(path) == {"v[1]": 1.0, "v[2]": 2.0, "v[3]": 3.0}


def test_a_structural_parameter_gives_arrays_their_size(tmp_path):
    text = (
        '<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="t">'
        '<CoSimulation modelIdentifier="m"/><ModelVariables>'
        '<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>'
        '<UInt64 name="n" valueReference="9" causality="structuralParameter" variability="fixed" start="3"/>'
        '<Float64 name="v" valueReference="1" causality="parameter" variability="fixed" start="0 0 0">'
        '<Dimension valueReference="9"/></Float64></ModelVariables><ModelStructure/></fmiModelDescription>'
    )
    files = {"resources/array.fmu": packed({"modelDescription.xml": text})}
    two = '<ssv:Parameter name="v"><ssv:Float64 value="1 2"/><ssc:Dimension size="2"/></ssv:Parameter>'
    port = '<ssd:Connector name="v" kind="parameter"><ssc:Float64/><ssc:Dimension size="2"/></ssd:Connector>'

    def archive(*values):
        given = bindings(binding(parameter_set(*values)))
        a = component("a", given, ports=(port,), source="resources/array.fmu")
        return write(tmp_path, structure(system(a), version="2.0"), files)

    assert start(archive(parameter("n", "UInt64", "2"), two)) == {"n": 2, "v[1]": 1.0, "v[2]": 2.0}
    assert "Connector 'v': shape differs from that of m, got 2, expected 3" in faults(archive(two))
