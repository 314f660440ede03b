"""Files of an SSP: archives, folders, nested packages, times; nothing outside, nothing unknown, nothing left behind."""

import random
import stat
import tempfile
import zipfile

import pytest

from master.errors import ConfigError
from master.experiment.prepare import Request, prepare
from tests.master.ssp.ssp_archives import (
    ENUMERATIONS,
    EXPERIMENT,
    NAMESPACES,
    UNITS,
    binding,
    bindings,
    component,
    connector,
    connectors,
    fmu,
    link,
    links,
    packed,
    parameter,
    parameter_set,
    structure,
    system,
    write,
)

ONE = system(component("a"))
NOTE = '<ssd:Annotations><ssc:Annotation type="x"><x:Odd/><b xmlns="not.absolute"/></ssc:Annotation></ssd:Annotations>'
PACKAGE = 'type="application/x-ssp-package"'
DEFINITION = 'type="application/x-ssp-definition"'


def faults(path, **request):
    with pytest.raises(ConfigError) as caught:
        prepare(path, Request(**request))
    return "\n".join(caught.value.problems)


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """The temporary folder, for this test alone."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def inner(value=3):
    """A system with a connector on each side and a value of its own."""
    ports = connectors(connector("u", "input"), connector("y", "output"))
    given = bindings(binding(parameter_set(parameter("g.p", "Real", str(value)))))
    return system(
        component("g"), before=ports + given, after=links(link(".u", "g.u"), link("g.y", ".y")), name="inner"
    )


def outer(source, kind, more=""):
    sub = f'<ssd:Component name="sub" source="{source}" {kind}>{more}</ssd:Component>'
    return system(component("a"), sub, after=links(link("a.y", "sub.u"), link("sub.y", "a.u")))


@pytest.mark.parametrize(
    ("source", "kind", "files"),
    [
        (
            "resources/sub.ssp",
            PACKAGE,
            {
                "resources/sub.ssp": packed(
                    {"SystemStructure.ssd": structure(inner()), "resources/box.fmu": fmu()}
                )
            },
        ),
        (
            "resources/sub.ssp#B.ssd",
            PACKAGE,
            {
                "resources/sub.ssp": packed(
                    {
                        "SystemStructure.ssd": structure(ONE),
                        "B.ssd": structure(inner()),
                        "resources/box.fmu": fmu(),
                    }
                )
            },
        ),
        (
            "resources/sub.ssd",
            DEFINITION,
            {"resources/sub.ssd": structure(inner()).replace("resources/", "")},
        ),
        ("sub.ssd", DEFINITION, {"sub.ssd": structure(inner())}),
    ],
)
@pytest.mark.parametrize(
    ("own", "value"), [("", 3.0), (bindings(binding(parameter_set(parameter("g.p", "Real", "8")))), 8.0)]
)
def test_a_component_may_be_a_system_of_another_file(tmp_path, source, kind, files, own, value):
    found = prepare(write(tmp_path, outer(source, kind, own), files)).system

    assert {w.target.name: w.source.name for w in found.wires} == {"a.u": "sub/g.y", "sub/g.u": "a.y"}
    assert dict(found.instances["sub/g"].start) == {"p": value}


def test_a_component_may_be_a_system_of_the_same_file(tmp_path):
    definition = inner().replace('name="inner"', 'name="inner" id="it"')
    content = system(
        definition,
        '<ssd:Component name="twin" source="#it" type="application/x-ssp-definition"/>',
        after=links(link("inner.y", "twin.u")),
    )
    found = prepare(write(tmp_path, content)).system

    assert [(w.source.name, w.target.name) for w in found.wires] == [("inner/g.y", "twin/g.u")]


@pytest.mark.parametrize(
    ("content", "files", "said"),
    [
        (outer("sub.ssd", DEFINITION), {"sub.ssd": structure(outer("sub.ssd", DEFINITION))}, "contains itself"),
        (outer("SystemStructure.ssd", DEFINITION), {}, "contains itself"),
        (system(component("a"), '<ssd:Component name="s" source="#me" type="application/x-ssp-definition"/>',
                attributes='id="me"'), {}, "contains itself"),
        (outer("resources/nix.ssp", PACKAGE), {}, "no such file, got 'resources/nix.ssp'"),
        (outer("resources/box.fmu", PACKAGE), {}, "no SystemStructure.ssd at the root of the archive, got none"),
        (outer("#nix", DEFINITION), {}, "no system with this id in the file, got '#nix'"),
        (outer("sub.ssd", DEFINITION, connectors(connector("z", "input"))), {"sub.ssd": structure(inner())},
         "no such connector of 'sub.ssd'"),
    ],
)  # fmt: skip
def test_a_nested_file_is_refused_by_name(tmp_path, content, files, said):
    assert said in faults(write(tmp_path, content, files))


@pytest.mark.parametrize("source", ["resources/my%20box.fmu", "resources/my box.fmu", "file:resources/my%20box.fmu",
                                    "resources\\my box.fmu", "./resources/x/../my%20box.fmu"])  # fmt: skip
def test_a_source_is_a_uri_or_a_path(tmp_path, source):
    path = write(tmp_path, system(component("a", source=source)), {"resources/my box.fmu": fmu()})

    assert list(prepare(path).system.instances) == ["a"]


@pytest.mark.parametrize(
    "source", ["../box.fmu", "/box.fmu", "file:///box.fmu", "resources/../../box.fmu", "http://a.b/box.fmu", "C:/box.fmu"]
)  # fmt: skip
def test_a_source_outside_the_archive_is_refused(tmp_path, source):
    (tmp_path / "box.fmu").write_bytes(fmu())

    assert "Component 'a': source: outside the archive" in faults(
        write(tmp_path, system(component("a", source=source)))
    )


def test_an_unpacked_structure_of_any_name_is_read(tmp_path):
    (tmp_path / "resources").mkdir()
    (tmp_path / "resources" / "box.fmu").write_bytes(fmu())
    path = tmp_path / "My System.ssd"
    path.write_text(structure(ONE))

    assert list(prepare(path).system.instances) == ["a"]


def test_an_unpacked_structure_reads_nothing_outside_its_folder(tmp_path):
    (tmp_path / "box.fmu").write_bytes(fmu())
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "link.fmu").symlink_to(tmp_path / "box.fmu")
    path = folder / "s.ssd"
    for source in ("../box.fmu", "link.fmu"):
        path.write_text(structure(system(component("a", source=source))))
        assert f"{path}:3: Component 'a': source: " in faults(path)


def test_an_archive_with_one_structure_of_another_name_is_read(tmp_path):
    path = tmp_path / "s.ssp"
    path.write_bytes(packed({"Other.ssd": structure(ONE), "resources/box.fmu": fmu()}))

    assert list(prepare(path).system.instances) == ["a"]


def test_of_several_structures_the_standard_one_is_read_and_said(tmp_path):
    path = write(tmp_path, ONE, {"B.ssd": structure(ONE)})

    assert "SystemStructure.ssd is read, not B.ssd" in prepare(path).notes


@pytest.mark.parametrize(
    ("files", "said"),
    [
        ({"A.ssd": structure(ONE), "B.ssd": structure(ONE)}, "no SystemStructure.ssd at the root of the archive, got A.ssd, B.ssd"),
        ({"folder/SystemStructure.ssd": structure(ONE)}, "got folder/SystemStructure.ssd"),
        ({}, "got none"),
    ],
)  # fmt: skip
def test_an_archive_without_its_structure_is_refused(tmp_path, files, said):
    path = tmp_path / "s.ssp"
    path.write_bytes(packed(files))

    assert said in faults(path)


@pytest.mark.parametrize(
    ("experiment", "span", "said"),
    [
        (EXPERIMENT, (0.0, 0.01), None),
        ('<ssd:DefaultExperiment startTime="2" stopTime="2.5"/>', (2.0, 2.5), None),
        ('<ssd:DefaultExperiment startTime="2"/>', (2.0, 3.0), "the file has no stopTime: stepped from 2 s to 3 s"),
        ('<ssd:DefaultExperiment stopTime="2"/>', (0.0, 2.0), "the file has no startTime: stepped from 0 s to 2 s"),
        ("", (0.0, 1.0), "the file has no startTime and no stopTime: stepped from 0 s to 1 s"),
    ],
)  # fmt: skip
def test_times_are_those_of_the_file_or_said(tmp_path, experiment, span, said):
    found = prepare(write(tmp_path, structure(ONE, more=UNITS + ENUMERATIONS + experiment)))

    assert (found.config.start_time, found.config.stop_time) == span
    assert said is None or said in found.notes
    assert said is not None or not any("startTime" in note or "stopTime" in note for note in found.notes)


def test_the_step_that_is_taken_is_said(tmp_path):
    path = write(tmp_path, ONE)
    default, chosen = prepare(path), prepare(path, Request(step_size=0.005))

    assert (default.config.step_size, chosen.config.step_size) == (1e-3, 0.005)
    assert (
        "SSP names no order and no step size: stepped side by side, every 0.001 s (--step-size sets another)"
        in default.notes
    )
    assert "SSP names no order and no step size: stepped side by side, every 0.005 s" in chosen.notes


def test_a_stop_time_that_is_no_multiple_of_the_step_does_not_matter_where_it_is_replaced(tmp_path):
    path = write(tmp_path, ONE, {})
    path = write(
        tmp_path, structure(ONE, more=UNITS + ENUMERATIONS + '<ssd:DefaultExperiment stopTime="0.0105"/>')
    )

    assert "s.ssp: SystemStructure.ssd:12: DefaultExperiment: 10.5 steps after start_time" in faults(path)
    assert prepare(path, Request(stop_time=0.02)).config.stop_time == 0.02
    assert prepare(path, Request(step_size=0.0005)).config.n_ticks == 21


@pytest.mark.parametrize("step_size", [0.0, -1.0, float("nan"), float("inf"), 0.003])
def test_a_step_size_that_does_not_fit_is_refused(tmp_path, step_size):
    assert faults(write(tmp_path, ONE), step_size=step_size)


@pytest.mark.parametrize("version", ["1.0", "1.1", "2.0", "2.0-beta.1"])
def test_versions_1_and_2_are_read(tmp_path, version):
    assert prepare(write(tmp_path, structure(ONE, version=version)))


HARMLESS = (
    '<ssd:ElementGeometry x1="0" y1="0" x2="1" y2="1" rotation="90" iconSource="resources/i.png"/>'
    "<ssd:Connections/>"
    '<ssd:SystemGeometry x1="0" y1="0" x2="1" y2="1"/>'
    '<ssd:GraphicalElements><ssd:Note x1="0" y1="0" x2="1" y2="1" text="hello"/></ssd:GraphicalElements>'
    '<ssd:Annotations><ssc:Annotation type="org.other"><x:y xmlns:x="urn:x" z="1">text</x:y></ssc:Annotation>'
    "</ssd:Annotations>"
)


def test_what_is_harmless_is_read_over_and_other_tools_annotations_are_said(tmp_path):
    text = structure(system(component("a", attributes='description="d" id="i"'), before=HARMLESS)).replace(
        'name="s"', 'name="s" author="me" license="BSD" generationTool="t" generationDateAndTime="2026-01-01T00:00:00Z" '
        'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="a b"'
    )  # fmt: skip

    assert "annotations of other tools are not read: org.other" in prepare(write(tmp_path, text)).notes


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (structure(ONE, version="3.0"), "version: not allowed, got '3.0', expected 1.0 or 2.0"),
        (structure(ONE).replace('version="1.0" name', "name"), "version is missing"),
        (structure(ONE)[:-9], "s.ssp: SystemStructure.ssd: not XML"),
        ("<?xml version='1.0'?><a/>", "not understood, got a, expected ssd:SystemStructureDescription"),
        ("<?xml version='1.0'?><!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>", "a document type is not understood"),
        (structure(ONE).replace("<ssd:Elements>", "<ssd:Elements><x:Odd/>"), "not XML: Namespace prefix x on Odd"),
        (structure(ONE, more=NOTE), "not XML: Namespace prefix x on Odd is not defined, line"),
        (structure(ONE, more=NOTE.replace("x:Odd", "Odd")) + "<a/>", "not XML: Extra content at the end"),
        (structure(ONE).replace("SSP1", "SSP9"), "expected ssd:SystemStructureDescription"),
        (structure(ONE).replace("</ssd:Elements>", "</ssd:Elements><ssd:Solver h='1'/>"), "Solver: not understood in ssd:System"),
        (structure(ONE).replace('name="a"', 'name="a" stepSize="1"'), "Component 'a': stepSize is not understood, got '1'"),
        (structure(ONE).replace('name="a"', ""), "Component: name is missing"),
        (structure(ONE).replace('name="a"', 'name=""'), "Component '': name: not allowed, got ''"),
        (structure(ONE).replace("<ssd:Elements>", "<ssd:Elements>text"), "text is not understood"),
        (structure(ONE).replace('stopTime="0.01"', 'stopTime="0,01"'), "stopTime: not allowed, got '0,01'"),
        (structure(ONE).replace('stopTime="0.01"', 'stopTime="NaN"'), "DefaultExperiment"),
        (structure(ONE).replace('stopTime="0.01"', 'stopTime="-1"'), "SystemStructure.ssd:12: DefaultExperiment: "),
        (structure(ONE, more=UNITS + UNITS), "Units: twice in ssd:SystemStructureDescription"),
        (structure(ONE, more=UNITS.replace('"km"', '"m"')), "Unit 'm': twice, expected one Unit of a name"),
        (structure(ONE, more=UNITS.replace('factor="1000"', 'factor="0"')), "cannot be converted, got factor 0"),
        (structure(ONE, more=EXPERIMENT), ""),
        (structure(system(component("a"), component("a"))), "Component 'a': twice in its system"),
        (structure(system(component("a", attributes='implementation="ModelExchange"'))), "not for co-simulation, got implementation 'ModelExchange'"),
        (structure(system(component("a", attributes='type="text/x-modelica"'))), "a component of this type cannot be stepped, got 'text/x-modelica'"),
        (structure(system(component("a", source="resources/nix.fmu"))), "no such file, got 'resources/nix.fmu'"),
        (structure(system(component("a", source="resources/box.fmu#x"))), "an FMU has no parts"),
        (structure(system(component("a", source="SystemStructure.ssd"))), "Component 'a': not an FMU"),
        (structure(system(component("a", source="resources/me.fmu"))), "Component 'a': not for co-simulation, got an FMU for model exchange only"),
        (structure("<ssd:System name='root'/>"), "System 'root': nothing to step, got no component, expected an FMU"),
    ],
)  # fmt: skip
def test_what_is_not_understood_is_refused_by_name(tmp_path, temporary, text, said):
    path = write(tmp_path, text, {"resources/me.fmu": fmu(kind="ModelExchange")})
    if not said:
        assert prepare(path)
        return
    found = faults(path)

    assert said in found
    assert str(temporary) not in found
    assert str(path) in found
    assert list(temporary.iterdir()) == []


def test_a_message_names_archive_file_line_and_element(tmp_path):
    text = structure("\n\n" + ONE.replace("/>", "/>").replace("resources/box.fmu", "nix.fmu"))
    path = write(tmp_path, text)

    assert (
        faults(path)
        == f"{path}: SystemStructure.ssd:5: Component 'a': source: no such file, got 'nix.fmu', expected one in {path}"
    )


def broken(path, how):
    good = path.read_bytes()
    if how == "cut":
        path.write_bytes(good[: len(good) // 2])
    elif how == "corrupt":
        at = good.index(b"SystemStructure.ssd") + 60
        path.write_bytes(good[:at] + bytes(b ^ 0x5A for b in good[at : at + 200]) + good[at + 200 :])
    elif how == "empty":
        path.write_bytes(b"")
    elif how == "missing":
        path.unlink()
    elif how == "folder":
        path.unlink()
        path.mkdir()
    elif how == "encrypted":
        data = bytearray(good)
        for signature, offset in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
            at = data.find(signature)
            while at >= 0:
                data[at + offset] |= 1
                at = data.find(signature, at + 1)
        path.write_bytes(data)
    else:
        with zipfile.ZipFile(path, "a") as archive:
            if how == "bzip2":
                archive.writestr("resources/x.txt", "x" * 99, zipfile.ZIP_BZIP2)
            elif how == "lzma":
                archive.writestr("resources/x.txt", "x" * 99, zipfile.ZIP_LZMA)
            elif how == "bomb":
                archive.writestr("resources/x.bin", bytes(2**25), zipfile.ZIP_DEFLATED)
            elif how == "link":
                info = zipfile.ZipInfo("resources/x.fmu")
                info.external_attr = (stat.S_IFLNK | 0o777) << 16
                archive.writestr(info, "/etc/passwd")
            else:
                archive.writestr(how, "x")


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("cut", "not an SSP archive ("),
        ("corrupt", "'SystemStructure.ssd': corrupt, got"),
        ("empty", "not an SSP archive ("),
        ("missing", "no such file, expected an SSP archive"),
        ("folder", "not an SSP archive ("),
        ("encrypted", "'SystemStructure.ssd': encrypted, expected a file without password"),
        ("bzip2", "'resources/x.txt': packed by a method that SSP does not allow, got bzip2 (12)"),
        ("lzma", "got lzma (14), expected stored or deflate"),
        ("bomb", "'resources/x.bin': grows 1029 times when unpacked, expected at most 200 times"),
        ("link", "'resources/x.fmu': a link, expected files alone"),
        ("../x.txt", "'../x.txt': leads outside the archive"),
        ("/x.txt", "'/x.txt': leads outside the archive"),
        ("a\\..\\..\\x.txt", "'a/../../x.txt': leads outside the archive"),
        ("resources\\box.fmu", "'resources/box.fmu': twice in the archive"),
    ],
)
def test_an_archive_that_is_not_safe_is_refused_and_leaves_nothing(tmp_path, temporary, how, said):
    path = write(tmp_path, ONE)
    broken(path, how)
    found = faults(path)

    assert said in found
    assert str(path) in found
    assert list(temporary.iterdir()) == []
    assert not (tmp_path / "x.txt").exists()


def test_an_archive_packed_with_backslashes_is_read(tmp_path):
    path = tmp_path / "s.ssp"
    path.write_bytes(packed({"SystemStructure.ssd": structure(ONE), "resources\\box.fmu": fmu()}))

    assert list(prepare(path).system.instances) == ["a"]


@pytest.mark.parametrize("name", ["my pump", "über.häuser", "a<b>", "%20", "'quoted'", "a&amp;b"])
def test_elements_of_any_name_are_read(tmp_path, name):
    content = system(
        component(name),
        component("b"),
        after=links(link(f"{name}.y", "b.u").replace('"my pump"', '"my pump"')),
    )
    text = structure(content)
    if "." in name:  # `link` splits at the first dot
        text = text.replace(
            'startElement="über" startConnector="häuser.y"', 'startElement="über.häuser" startConnector="y"'
        )
    found = prepare(
        write(tmp_path, text.replace('name="a<b>"', 'name="a&lt;b&gt;"').replace('"a<b>"', '"a&lt;b&gt;"'))
    ).system

    assert len(found.wires) == 1


def test_a_value_over_several_files_names_the_file_and_line(tmp_path):
    text = parameter_set("\n", parameter("p", "Real", "x"), namespaces=NAMESPACES)
    path = write(
        tmp_path,
        system(component("a", bindings(binding(attributes='source="resources/p.ssv"')))),
        {"resources/p.ssv": text},
    )

    assert faults(path) == f"{path}: resources/p.ssv:2: Parameter 'p': not a Real, got 'x', expected a number"


def read_or_refused(path):
    try:
        prepare(path)
    except ConfigError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("seed", range(4))
def test_no_damage_to_a_file_ends_in_anything_but_a_refusal(tmp_path, temporary, seed):
    """Bytes and words of structure and archive are changed at random; each time it is read or refused."""
    random_ = random.Random(seed)
    good = structure(outer("sub.ssd", DEFINITION))
    answers = []
    words = [*'"<>/&#1 \x00é', "ssd:", "ssc:", "-1", "1e400", "name", "source", "..", "input"]
    for _ in range(60):
        text = good
        for _ in range(random_.randint(0, 3)):
            at = random_.randrange(len(text))
            text = text[:at] + random_.choice(words) + text[at + random_.randint(0, 6) :]
        path = write(tmp_path, "<?xml" + text[5:], {"sub.ssd": structure(inner())})
        if random_.random() < 0.3:
            data = bytearray(path.read_bytes())
            for _ in range(5):
                data[random_.randrange(len(data))] = random_.randrange(256)
            path.write_bytes(data)
        answers.append(read_or_refused(path))
    assert not any(str(temporary) in answer for answer in answers)
    assert len({answer == "" for answer in answers}) == 2  # some are read, some refused
