"""Connections of SSP: transformations, units, types, direction; what each wire carries, what is refused."""

import pytest

from master.errors import ConfigError
from master.experiment.prepare import Request, prepare
from tests.master.ssp.ssp_archives import (
    component,
    connector,
    connectors,
    link,
    links,
    packed,
    structure,
    system,
    write,
)


def two(*connections, a=None, b=None):
    return system(component("a", ports=a), component("b", ports=b), after=links(*connections))


def wires(path):
    return {w.target.name: w for w in prepare(path).system.wires}


def faults(path):
    with pytest.raises(ConfigError) as caught:
        prepare(path)
    return "\n".join(caught.value.problems)


LINEAR = '<ssc:LinearTransformation factor="2" offset="3"/>'
MAPS = {
    "Boolean": '<ssc:BooleanMappingTransformation><ssc:MapEntry source="true" target="0"/>'
    '<ssc:MapEntry source="0" target="true"/></ssc:BooleanMappingTransformation>',
    "Integer": '<ssc:IntegerMappingTransformation><ssc:MapEntry source="1" target="5"/>'
    '<ssc:MapEntry source="2" target="-7"/></ssc:IntegerMappingTransformation>',
    "Enumeration": '<ssc:EnumerationMappingTransformation><ssc:MapEntry source="slow" target="fast"/>'
    '<ssc:MapEntry source="fast" target="slow"/></ssc:EnumerationMappingTransformation>',
}


@pytest.mark.parametrize(
    ("connection", "sent", "arrives"),
    [
        (link("a.y", "b.u", LINEAR), 5.0, 13.0),
        (link("b.u", "a.y", LINEAR), 5.0, 13.0),  # start and end do not give the direction
        (link("a.b_y", "b.b", MAPS["Boolean"]), 1.0, 0.0),
        (link("a.b_y", "b.b", MAPS["Boolean"]), 0.0, 1.0),
        (link("a.i_y", "b.i", MAPS["Integer"]), 2.0, -7.0),
        (link("a.i_y", "b.i", MAPS["Integer"]), 3.0, 3.0),  # what no entry names is kept
        (link("a.e_y", "b.e", MAPS["Enumeration"]), 1.0, 2.0),
        (link("a.e_y", "b.e", MAPS["Integer"]), 1.0, 5.0),
        (link("a.y", "b.f", "", 'suppressUnitConversion="1"'), 5.0, 5.0),
        (link("a.y", "b.f", LINEAR, 'suppressUnitConversion="true"'), 5.0, 13.0),
        (link("a.y", "b.bare", "<ssc:LinearTransformation/>"), 5.0, 5.0),
    ],
)
def test_a_connection_carries(tmp_path, connection, sent, arrives):
    [wire] = wires(write(tmp_path, two(connection))).values()

    assert wire.conversion.of(sent) == arrives


@pytest.mark.parametrize(
    ("unit_a", "unit_b", "more", "arrives"),
    [
        ("mm", "m", "", 0.006),
        ("m", "mm", "", 6000.0),
        ("mm", "m", LINEAR, 3.012),  # the unit first, then 2 x + 3 in the unit of the target
        ("mm", "", "", 6.0),
    ],
)
def test_units_of_connectors_are_converted_where_the_fmu_has_none(tmp_path, unit_a, unit_b, more, arrives):
    a = (connector("bare_y", "output", "Real", unit_a),)
    b = (connector("bare", "input", "Real", unit_b),)
    [wire] = wires(write(tmp_path, two(link("a.bare_y", "b.bare", more), a=a, b=b))).values()

    assert wire.conversion.of(6.0) == pytest.approx(arrives, rel=1e-15)


def test_a_temperature_is_converted_with_its_offset(tmp_path):
    a = (connector("bare_y", "output", "Real", "degC"),)
    b = (connector("bare", "input", "Real", "kelvin"),)
    [wire] = wires(write(tmp_path, two(link("a.bare_y", "b.bare"), a=a, b=b))).values()

    assert wire.conversion.of(20.0) == pytest.approx(293.15)


def nested(inner_links, outer_links, *, u="", y="", sub=""):
    inside = connectors(connector("u", "input", "Real", u), connector("y", "output", "Real", y))
    inner = system(component("g"), before=inside, after=links(*inner_links), name="sub")
    return system(component("a"), inner, component("c"), after=links(*outer_links))


def test_a_nested_system_hands_on_with_every_transformation_of_the_way(tmp_path):
    content = nested(
        [link(".u", "g.u", LINEAR), link("g.y", ".y", LINEAR)],
        [link("a.y", "sub.u", LINEAR), link("sub.y", "c.u")],
    )
    found = wires(write(tmp_path, content))

    assert found["sub/g.u"].source.name == "a.y"
    assert found["sub/g.u"].conversion.of(1.0) == 2 * (2 * 1 + 3) + 3
    assert found["c.u"].source.name == "sub/g.y"
    assert found["c.u"].conversion.of(1.0) == 5.0


def test_units_are_converted_at_each_connector_that_names_one(tmp_path):
    content = nested([link(".u", "g.u", LINEAR)], [link("a.y", "sub.u")], u="km")
    [wire] = wires(write(tmp_path, content)).values()

    assert wire.conversion.of(5000.0) == pytest.approx(2 * 5000.0 + 3)  # 5 km -> 5000 m -> 2 x + 3


def test_a_system_passes_from_its_input_to_its_output(tmp_path):
    inside = connectors(connector("u", "input"), connector("y", "output"))
    through = f'<ssd:System name="wire">{inside}{links(link(".u", ".y", LINEAR))}</ssd:System>'
    content = system(
        component("a"), component("c"), through, after=links(link("a.y", "wire.u"), link("wire.y", "c.u"))
    )
    [wire] = wires(write(tmp_path, content)).values()

    assert (wire.source.name, wire.target.name) == ("a.y", "c.u")
    assert wire.conversion.of(1.0) == 5.0


def test_a_unit_that_no_connector_names_is_not_guessed(tmp_path):
    a = (connector("bare_y", "output", "Real", "mm"),)
    inside = connectors(connector("u", "input", "Real"))
    inner = system(component("g"), before=inside, after=links(link(".u", "g.u")), name="sub")
    content = system(component("a", ports=a), inner, after=links(link("a.bare_y", "sub.u", LINEAR)))

    assert "the unit of a transformed value is not known" in faults(write(tmp_path, content))


DICTIONARY = (
    '<ssd:SignalDictionaries><ssd:SignalDictionary name="bus"><ssb:SignalDictionary version="1.0">'
    '<ssb:DictionaryEntry name="way"><ssc:Real unit="km"/></ssb:DictionaryEntry>'
    "</ssb:SignalDictionary></ssd:SignalDictionary></ssd:SignalDictionaries>"
)


def reference(name, kind="inout", entry="way", dictionary="bus"):
    return (
        f'<ssd:SignalDictionaryReference name="{name}" dictionary="{dictionary}">'
        f"{connectors(connector(entry, kind))}</ssd:SignalDictionaryReference>"
    )


def test_a_dictionary_hands_one_source_to_all_that_read_it_in_any_system(tmp_path):
    inner = system(component("g"), reference("in"), after=links(link("in.way", "g.u")), name="sub")
    content = system(
        component("a"),
        component("c"),
        inner,
        reference("out"),
        after=links(link("a.y", "out.way"), link("out.way", "c.u")) + DICTIONARY,
    )
    found = wires(write(tmp_path, content))

    assert {name: w.source.name for name, w in found.items()} == {"sub/g.u": "a.y", "c.u": "a.y"}
    assert found["c.u"].conversion.of(2.0) == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("elements", "connections", "said"),
    [
        (
            [component("a"), component("c"), reference("r")],
            [link("a.y", "r.way"), link("c.y", "r.way"), link("r.way", "a.u")],
            "two sources",
        ),
        (
            [component("a"), component("c"), reference("r"), reference("q")],
            [link("a.y", "r.way"), link("c.y", "q.way")],
            "bus.way is a bus with several sources",
        ),
        ([component("a"), reference("r", entry="x")], [], "no such entry in 'bus'"),
        (
            [component("a"), reference("r", dictionary="b")],
            [],
            "no such dictionary, got 'b', expected one of bus",
        ),
    ],
)
def test_a_bus_is_refused(tmp_path, elements, connections, said):
    content = system(*elements, after=links(*connections) + DICTIONARY)

    assert said in faults(write(tmp_path, content))


@pytest.mark.parametrize(
    ("connection", "said"),
    [
        (link("a.y", "b.f"), "Connection a.y - b.f: units differ, got m -> N"),
        (link("a.y", "b.i"), "types differ, got Real -> Integer"),
        (link("a.i_y", "b.b"), "types differ, got Integer -> Boolean"),
        (link("a.e_y", "b.w"), "enumerations differ, got slow, fast -> back, slow"),
        (link("a.i_y", "b.i", LINEAR), "LinearTransformation is for Real alone, got Integer"),
        (
            link("a.y", "b.u", MAPS["Integer"]),
            "IntegerMappingTransformation is for Integer and Enumeration alone",
        ),
        (
            link("a.i_y", "b.i", MAPS["Boolean"]),
            "BooleanMappingTransformation is for Boolean alone, got Integer",
        ),
        (
            link("a.e_y", "b.w", MAPS["Enumeration"]),
            "no such item of the target's enumeration, got 'fast', expected",
        ),
        (link("a.k", "b.p"), "cannot be carried, got calculatedParameter -> parameter"),
        (link("a.y", "b.p"), "not allowed, got output -> parameter"),
        (link("a.y", "b.y"), "no direction, got output and output"),
        (link("a.u", "b.u"), "no direction, got input and input"),
        (link("a.z", "b.u"), "no such connector of 'a', got 'z'"),
        (link("x.y", "b.u"), "no such element, got 'x', expected one of a, b"),
        (link(".y", "b.u"), "no such connector of the system, got 'y'"),
        (link("a.y", "b.u") + link("a.bare_y", "b.u"), "b.u has two sources, got a.y and a.bare_y"),
        (link("a.y", "b.u", LINEAR, 'startIndices="1"'), "startIndices is not understood, got '1'"),
        (link("a.y", "b.u", '<ssc:LinearTransformation factor="1,5"/>'), "factor: not allowed, got '1,5'"),
        (link("a.y", "b.u", '<ssc:LinearTransformation factor="INF"/>'), "not finite, got factor inf"),
        (link("a.y", "b.u", LINEAR + LINEAR), "twice in ssd:Connection, expected once"),
        (link("a.y", "b.u", "<ssc:Square/>"), "Square: not understood in ssd:Connection"),
        (
            link(
                "a.i_y",
                "b.i",
                '<ssc:IntegerMappingTransformation><ssc:MapEntry source="1" target="2"/>'
                '<ssc:MapEntry source="01" target="3"/></ssc:IntegerMappingTransformation>',
            ),
            "'1' is mapped twice",
        ),
        (
            link(
                "a.i_y",
                "b.i",
                '<ssc:IntegerMappingTransformation><ssc:MapEntry source="1.5" target="2"/>'
                "</ssc:IntegerMappingTransformation>",
            ),
            "expected an integer from -2147483648 to 2147483647",
        ),
    ],
)
def test_a_connection_is_refused_by_name(tmp_path, connection, said):
    found = faults(write(tmp_path, two(connection)))

    assert said in found
    assert "SystemStructure.ssd:" in found


@pytest.mark.parametrize(
    ("port", "said"),
    [
        (connector("nix", "input"), "Connector 'nix': no such variable in box"),
        (connector("u", "output"), "kind differs from the FMU's, got output, expected input"),
        (connector("u", "input", "Integer"), "type differs from the FMU's, got Integer, expected Real"),
        (connector("u", "input", "Real", "mm"), "unit differs from the FMU's, got 'mm', expected 'm'"),
        (connector("u", "input", "Real", "N"), "unit differs from the FMU's, got 'N', expected 'm'"),
        (connector("u", "input") * 2, "Connector 'u': twice on 'a', expected one of a name"),
        (connector("u", "sideways"), "kind: not allowed, got 'sideways'"),
    ],
)
def test_a_connector_that_contradicts_its_fmu_is_refused(tmp_path, port, said):
    assert said in faults(write(tmp_path, two(a=(port,))))


def test_all_faults_come_at_once(tmp_path):
    found = faults(write(tmp_path, two(link("a.y", "b.i"), link("a.y", "b.b"), link("a.k", "b.p"))))

    assert len(found.splitlines()) == 3


ARRAYS = """<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="t">
<CoSimulation modelIdentifier="m"/><ModelVariables>
<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
<Float64 name="v" valueReference="1" causality="input" variability="continuous" start="0 0 0"><Dimension start="3"/></Float64>
<Float64 name="w" valueReference="2" causality="output" variability="continuous"><Dimension start="3"/></Float64>
<Float64 name="q" valueReference="8" causality="input" variability="continuous" start="0 0 0 0"><Dimension start="2"/><Dimension start="2"/></Float64>
<Float64 name="y" valueReference="5" causality="output" variability="continuous"/>
<Binary name="x" valueReference="3" causality="output" variability="discrete"/>
<Binary name="xi" valueReference="4" causality="input" variability="discrete"><Start value=""/></Binary>
<Clock name="c" valueReference="6" causality="output" intervalVariability="triggered"/>
<Clock name="ci" valueReference="7" causality="input" intervalVariability="triggered"/>
</ModelVariables><ModelStructure><Output valueReference="2"/><Output valueReference="5"/></ModelStructure>
</fmiModelDescription>"""
THREE = '<ssc:Float64/><ssc:Dimension size="3"/>'


def port(name, kind, inner):
    return f'<ssd:Connector name="{name}" kind="{kind}">{inner}</ssd:Connector>'


def arrays(folder, a, b, wire, root=()):
    elements = [component(n, ports=p, source="resources/arrays.fmu") for n, p in (("a", a), ("b", b))]
    content = system(*elements, before=connectors(*root), after=links(*wire))
    return write(
        folder,
        structure(content, version="2.0"),
        {"resources/arrays.fmu": packed({"modelDescription.xml": ARRAYS})},
    )


def test_arrays_and_their_elements_are_connected(tmp_path):
    whole = (port("w", "output", THREE),), (port("v", "input", THREE),), (link("a.w", "b.v"),)
    assert {w.source.name: t for t, w in wires(arrays(tmp_path, *whole)).items()} == {
        f"a.w[{i}]": f"b.v[{i}]" for i in (1, 2, 3)
    }
    one = (
        (port("w[2]", "output", "<ssc:Float64/>"),),
        (port("v[1]", "input", "<ssc:Float64/>"),),
        (link("a.w[2]", "b.v[1]"),),
    )
    assert {w.source.name: t for t, w in wires(arrays(tmp_path, *one)).items()} == {"a.w[2]": "b.v[1]"}


def test_arrays_are_connectors_of_the_system(tmp_path):
    root = (port("in", "input", THREE), port("out", "output", THREE))
    ends = (link("a.w", ".out"), link(".in", "b.v"))
    path = arrays(tmp_path, (port("w", "output", THREE),), (port("v", "input", THREE),), ends, root)
    experiment = prepare(path, Request(assignments=("root.in=[1, 2, 3]",)))

    assert [w.target.name for w in experiment.system.outlets] == [f"root.out[{i}]" for i in (1, 2, 3)]
    assert experiment.system.instances["b"].start == {"v[1]": 1.0, "v[2]": 2.0, "v[3]": 3.0}


FOUR = '<ssc:Float64/><ssc:Dimension size="4"/>'
SQUARE = '<ssc:Float64/><ssc:Dimension size="2"/><ssc:Dimension size="2"/>'
NUMBER = "<ssc:Float64/>"


@pytest.mark.parametrize(
    ("a", "b", "said"),
    [
        (("w", THREE), ("q", SQUARE), "Connection a.w - b.q: shapes differ"),
        (("w", FOUR), ("v", THREE), "Connector 'w': shape differs from that of m, got 4, expected 3"),
        (("y", THREE), ("v", THREE), "Connector 'y': shape differs from that of m, got 3, expected a scalar"),
        (("y", NUMBER), ("v", THREE), "Connection a.y - b.v: no such input of b (m), got 'v'"),
        (("x", "<ssc:Binary/>"), ("xi", "<ssc:Binary/>"), "Connection a.x - b.xi: cannot be exchanged, got Binary"),
        (("x", ""), ("xi", ""), "Connection a.x - b.xi: cannot be exchanged, got Binary"),
        (("c", "<ssc:Clock/>"), ("ci", "<ssc:Clock/>"), "Connection a.c - b.ci: cannot be exchanged, got Clock"),
        (("y", '<ssc:Float64/><ssc:Clock name="c"/>'), ("v", THREE), "Connector 'y': a clock is not understood"),
    ],
)  # fmt: skip
def test_arrays_binaries_and_clocks_that_do_not_fit_are_refused_by_element_and_line(tmp_path, a, b, said):
    ends = port(a[0], "output", a[1]), port(b[0], "input", b[1])
    found = faults(arrays(tmp_path, ends[:1], ends[1:], (link(f"a.{a[0]}", f"b.{b[0]}"),)))

    assert f"{tmp_path}/s.ssp: SystemStructure.ssd:3: {said}" in found


def test_a_circle_of_connections_without_a_source_is_refused(tmp_path):
    through = system(
        before=connectors(connector("i", "input"), connector("o", "output")),
        after=links(link(".i", ".o")),
        name="sub",
    )
    content = system(through, component("a"), after=links(link("sub.o", "sub.i"), link("sub.o", "a.u")))

    assert "leads in a circle, expected a source" in faults(write(tmp_path, content))
