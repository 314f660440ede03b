import pytest

from master.errors import ConfigError
from master.text.scalar import Plain
from master.text.yaml_lines import dotted, parse_value, read_yaml

TEXT = """\
name: low
fmus:
  clock:
    source: clock.fmu
connections:
  - {from: a.x, to: b.u}
  - from: b.y
    to: a.u
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "system.yaml"
    path.write_text(TEXT, encoding="utf-8")
    return path


def faults(path):
    with pytest.raises(ConfigError) as caught:
        read_yaml(path)
    return [p.replace(f"{path.parent}/", "") for p in caught.value.problems]


@pytest.mark.parametrize(
    ("place", "line", "name"),
    [
        (("name",), 1, "name"),
        (("fmus", "clock", "source"), 4, "fmus.clock.source"),
        (("connections", 0, "to"), 6, "connections[0].to"),
        (("connections", 1), 7, "connections[1]"),
        (("connections", 1, "to"), 8, "connections[1].to"),
    ],
)
def test_every_key_knows_its_line(file, place, line, name):
    assert read_yaml(file).where(place) == f"{file}:{line}: {name}"


def test_a_missing_key_takes_the_line_of_its_parent(file):
    assert read_yaml(file).where(("fmus", "clock", "every")) == f"{file}:3: fmus.clock.every"


def test_the_whole_file_has_a_name():
    assert dotted(()) == "file"


@pytest.mark.parametrize("text", ["010", "1.10", "true", "1e3", "12:30", "2024-01-05", "yes", "null", "a b"])
def test_a_value_keeps_its_text(text):
    value = parse_value(text)

    assert isinstance(value, Plain)
    assert value == text


@pytest.mark.parametrize(("text", "value"), [("'010'", "010"), ('"a: b"', "a: b"), ("!!str 010", "010")])
def test_a_text_in_quotes_is_no_plain_text(text, value):
    assert parse_value(text) == value
    assert not isinstance(parse_value(text), Plain)


def test_an_empty_value_is_nothing():
    assert parse_value("") is None


@pytest.mark.parametrize("text", ["[{a: 1}]", "{a: 1}", "a: 1", "%}", "[", "*a", "@x"])
def test_what_is_no_scalar_and_no_list_of_scalars_is_no_value(text):
    with pytest.raises(ConfigError):
        parse_value(text)


LAUGHS = "a0: &a0 [x,x,x,x,x,x,x,x,x]\n" + "".join(
    f"a{i}: &a{i} [{','.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 9)
)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (LAUGHS, "system.yaml:6: not YAML: aliases repeat more than 100000 values"),
        ("name: x\na: &a [*a]\n", "system.yaml:2: not YAML: an alias within what it repeats, got *a"),
        ("a: &a {b: *a}\n", "system.yaml:1: not YAML: an alias within what it repeats, got *a"),
        ("a: *b\n", "system.yaml:1: not YAML: no anchor of this name, got *b"),
        (
            "\na: !!python/object/apply:os.system [ls]\n",
            "system.yaml:2: not YAML: tag not known, got '!!python/object/apply:os.system', expected none",
        ),
        ("a: !mine x\n", "system.yaml:1: not YAML: tag not known, got '!mine', expected none"),
        ("a: !!binary aGk=\n", "system.yaml:1: not YAML: tag not known, got '!!binary', expected none"),
        ("a: !!int x\n", "system.yaml:1: a: not a number, got 'x', expected what the tag !!int says"),
        ("a: 1\n---\na: 2\n", "system.yaml:2: not YAML: a second document, expected one"),
        ("a: " + "[" * 100 + "]" * 100, "system.yaml:1: not YAML: more than 60 levels"),
        (
            "x: 1\na: b\0c\n",
            "system.yaml:2: not YAML: unacceptable character #x0000: control characters are not allowed",
        ),
        (
            'a: "b\\0c"\n',
            "system.yaml:1: not YAML: NUL or a surrogate, expected characters of Unicode",
        ),
        (
            'a: "\\ud800"\n',
            "system.yaml:1: not YAML: found invalid Unicode character escape code",
        ),
        ("? [a]\n: b\n", "system.yaml:1: file: a key that is a list or a mapping, expected a name"),
        ("a:\n  <<: 3\n", "system.yaml:2: a.<<: not a mapping, expected one, or a list of mappings"),
    ],
)
def test_yaml_that_no_system_needs_is_refused_with_its_line(file, text, fault):
    file.write_text(text, encoding="utf-8")

    assert faults(file) == [fault]


def test_an_alias_repeats_a_value_and_a_merge_gives_what_is_not_given(file):
    file.write_text("a: &a {x: 1, y: 2}\nb: *a\nc:\n  <<: *a\n  y: 3\n", encoding="utf-8")

    assert read_yaml(file).data == {
        "a": {"x": "1", "y": "2"},
        "b": {"x": "1", "y": "2"},
        "c": {"x": "1", "y": "3"},
    }


def test_what_is_left_out_of_a_list_does_not_renumber_the_rest(file):
    document = read_yaml(file).without(("connections", 0))

    assert document.data["connections"] == [{"from": "b.y", "to": "a.u"}]
    assert document.where(("connections", 0, "to")) == f"{file}:8: connections[1].to"


def test_a_key_that_is_given_twice_is_refused_with_both_lines(file):
    file.write_text("name: a\nfmus: {}\nname: b\nfmus: {}\n", encoding="utf-8")

    assert faults(file) == [
        "system.yaml:3: name: key is given twice, first in line 1",
        "system.yaml:4: fmus: key is given twice, first in line 2",
    ]


def test_text_that_is_not_yaml_is_refused_with_its_line(file):
    file.write_text("name: a\nfmus: [\n", encoding="utf-8")

    assert faults(file) == ["system.yaml:3: not YAML: did not find expected node content"]


def test_a_missing_file_is_refused(file):
    file.unlink()

    assert faults(file) == [
        "system.yaml: cannot be read, got No such file or directory, expected a YAML file"
    ]


def test_bytes_that_are_not_text_are_refused(file):
    file.write_bytes(b"\xff\xfe\x00")

    assert faults(file) == ["system.yaml: not text, expected a YAML file in UTF-8"]
