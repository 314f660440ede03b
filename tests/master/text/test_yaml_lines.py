import pytest

from master.errors import ConfigError
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


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 0.001),
        ("-2E+4", -20000.0),
        (".5e1", 5.0),
        ("3", 3),
        ("0.5", 0.5),
        ("true", True),
        ("kalman", "kalman"),
        ("off", "off"),
        ("yes", "yes"),
        (".nan", pytest.approx(float("nan"), nan_ok=True)),
    ],
)
def test_a_value_reads_as_yaml_1_2_reads_it(text, value):
    parsed = parse_value(text)

    assert (type(parsed), parsed) == (type(value) if type(value) in (bool, int, str) else float, value)


def test_a_key_that_stands_twice_is_refused_with_both_lines(file):
    file.write_text("name: a\nfmus: {}\nname: b\nfmus: {}\n", encoding="utf-8")

    assert faults(file) == [
        "system.yaml:3: name: key stands twice, first in line 1",
        "system.yaml:4: fmus: key stands twice, first in line 2",
    ]


def test_text_that_is_not_yaml_is_refused_with_its_line(file):
    file.write_text("name: a\nfmus: [\n", encoding="utf-8")

    assert faults(file) == ["system.yaml:3: not YAML: expected the node content, but found '<stream end>'"]


def test_a_missing_file_is_refused(file):
    file.unlink()

    assert faults(file) == [
        "system.yaml: cannot be read, got No such file or directory, expected a YAML file"
    ]


def test_bytes_that_are_not_text_are_refused(file):
    file.write_bytes(b"\xff\xfe\x00")

    assert faults(file) == ["system.yaml: not text, expected a YAML file in UTF-8"]
