"""
A corpus of hostile input, made here: what comes as a file or from an FMU never becomes anything but data.

Each file is refused with one clear message, or neutralised, in bounded time and memory.
"""

import json
import stat
import struct
import tempfile
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from master.cli import main
from master.errors import ConfigError
from master.fmi import description_reader
from master.fmi.description_reader import read_description
from master.pages.chart import Chart, Curve
from master.pages.picture import data_uri
from master.process import temporary
from master.recording.formats.npz import read_npz
from master.system.config import load_config
from master.text import archive as archive_module
from master.text.archive import Archive, ArchiveError
from master.text.printable import printable

ESCAPES = ("\x1b[2J", "\x9b2J", "\x1b]0;title\x07", "\x1b]8;;http://x\x1b\\", "\u202e", "\r", "\x08", "\x7f")
SYSTEM = "name: s\nstop_time: 1\nfmus:\n  m: {source: m.fmu}\n"
VARIABLE = '<Float64 name="{name}" valueReference="{i}" causality="output" description="{name}"/>'


def description(variables, head=""):
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>{head}<fmiModelDescription fmiVersion="3.0" modelName="m" '
        'instantiationToken="t"><CoSimulation modelIdentifier="m"/>'
        f"<ModelVariables>{variables}</ModelVariables><ModelStructure/></fmiModelDescription>"
    )


def fmu(path, variables="", head="", **members):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as made:
        made.writestr("modelDescription.xml", description(variables, head))
        for name, content in members.items():
            made.writestr(name, content)
    return path


def answer(*arguments):
    done = CliRunner().invoke(main, [str(a) for a in arguments])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done


def zip_of(path, *infos):
    with zipfile.ZipFile(path, "w") as made:
        for info, content in infos:
            made.writestr(info, content)
    return path


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: &a [x,x,x,x,x,x,x,x,x,x]\n", "aliases repeat more than 100000 values"),
        ("fmus: !!python/object/apply:os.system ['touch owned']\n", "tag not known"),
        ("x: &x [*x]\n", "an alias within what it repeats"),
        ("[" * 5000, "more than 60 levels|maximum nesting depth"),
        ("? {a: b}\n: c\n", "a key that is a list or a mapping"),
        ("name: s\n---\nname: t\n", "a second document"),
    ],
)
def test_yaml_that_is_more_than_data_is_refused(tmp_path, text, said):
    if text.startswith("a: &a"):
        for i, letter in enumerate("bcdefgh"):
            text += f"{letter}: &{letter} [{', '.join(['*' + chr(ord('a') + i)] * 10)}]\n"
    file = tmp_path / "system.yaml"
    file.write_text(text)

    with pytest.raises(ConfigError, match=said):
        load_config(file)


@pytest.mark.parametrize(
    ("head", "name", "said"),
    [
        ('<!DOCTYPE x [<!ENTITY a "aaa">]>', "&amp;a", "a declaration of a document type"),
        ('<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/passwd">]>', "v", "a declaration of a document type"),
        ('<!DOCTYPE x SYSTEM "http://127.0.0.1:1/x.dtd">', "v", "a declaration of a document type"),
        (
            '<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>',
            "&b;",
            "a declaration of a document type",
        ),
    ],
)
def test_xml_with_entities_or_references_is_refused(tmp_path, head, name, said):
    path = fmu(tmp_path / "m.fmu", VARIABLE.format(name=name, i=1), head)

    with pytest.raises(ConfigError, match=said):
        read_description(path)


@pytest.mark.parametrize("sizes", [(10**7,), (600, 600), (2**31, 2**31)])
def test_arrays_of_more_elements_together_than_the_limit_are_refused(tmp_path, monkeypatch, sizes):
    most = 1000 if max(sizes) < 1000 else description_reader.MOST_ELEMENTS
    monkeypatch.setattr(description_reader, "MOST_ELEMENTS", most)
    arrays = "".join(
        f'<Float64 name="a{i}" valueReference="{i}" causality="output"><Dimension start="{n}"/></Float64>'
        for i, n in enumerate(sizes)
    )

    with pytest.raises(ConfigError, match=f"expected at most {most}"):
        read_description(fmu(tmp_path / "m.fmu", arrays))


def test_an_array_within_the_limit_is_read(tmp_path):
    array = '<Float64 name="a" valueReference="1" causality="output"><Dimension start="1000"/></Float64>'

    assert len(read_description(fmu(tmp_path / "m.fmu", array)).variables) == 1000


def unix(name, mode):
    info = zipfile.ZipInfo(name)
    info.create_system = 3
    info.external_attr = mode << 16
    return info


@pytest.mark.parametrize(
    ("info", "said"),
    [
        (zipfile.ZipInfo("../outside"), "leads out of the archive"),
        (zipfile.ZipInfo("a/../../outside"), "leads out of the archive"),
        (zipfile.ZipInfo("..\\outside"), "leads out of the archive"),
        (zipfile.ZipInfo("/etc/passwd"), "an absolute name"),
        (zipfile.ZipInfo("C:/windows"), "an absolute name"),
        (unix("link", stat.S_IFLNK | 0o777), "a link"),
        (zipfile.ZipInfo("modeldescription.XML"), "differ only in upper and lower case"),
        (zipfile.ZipInfo("modelDescription.xml/x"), "a file and a folder"),
    ],
)
def test_members_that_lead_out_or_replace_others_are_refused(tmp_path, info, said):
    path = zip_of(
        tmp_path / "m.fmu", (zipfile.ZipInfo("modelDescription.xml"), description("")), (info, "/etc/passwd")
    )

    with pytest.raises(ArchiveError, match=said):
        Archive(path)
    assert answer("inspect", path).exit_code == 2


def bomb(path, declared):
    """An archive of a few bytes whose directory declares a member of any size."""
    packed = zlib.compressobj(9, zlib.DEFLATED, -15)
    data = packed.compress(bytes(10**6)) + packed.flush()
    name = b"resources/zeros"
    common = struct.pack("<HHHHHIII", 20, 0, 8, 0, 33, 0, len(data), declared)
    local = b"PK\3\4" + common + struct.pack("<HH", len(name), 0) + name + data
    central = (
        b"PK\1\2" + struct.pack("<H", 20) + common + struct.pack("<HHHHHII", len(name), 0, 0, 0, 0, 0, 0)
    )
    central += name
    end = b"PK\5\6" + struct.pack("<HHHHIIH", 0, 0, 1, 1, len(central), len(local), 0)
    path.write_bytes(local + central + end)
    return path


def test_an_archive_that_unpacks_to_more_than_the_limit_is_refused_by_its_directory(tmp_path):
    with pytest.raises(ArchiveError, match="too large, got 3815 MB unpacked, expected at most 2048 MB"):
        Archive(bomb(tmp_path / "m.fmu", 4 * 10**9))


def test_a_member_that_is_larger_than_it_says_is_not_unpacked_beyond_that(tmp_path):
    with Archive(bomb(tmp_path / "m.fmu", 1000)) as opened, pytest.raises(ArchiveError, match="damaged"):
        opened.read("resources/zeros")


def test_a_large_member_is_not_read_whole_but_unpacked_piece_by_piece(tmp_path, monkeypatch):
    monkeypatch.setattr(archive_module, "MOST_READ", 10**6)
    content = np.random.default_rng(1).bytes(3 * 10**6)
    with Archive(zip_of(tmp_path / "m.fmu", (zipfile.ZipInfo("resources/x"), content))) as opened:
        with pytest.raises(ArchiveError, match="too large"):
            opened.read("resources/x")
        opened.verify("resources/x")
        folder = opened.unpacked(lambda name: True)

    assert (folder / "resources" / "x").read_bytes() == content
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_an_archive_of_too_many_members_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(archive_module, "MOST_MEMBERS", 10)
    members = [(zipfile.ZipInfo(f"{i}"), "") for i in range(11)]

    with pytest.raises(ArchiveError, match="too many members, got 11, expected at most 10"):
        Archive(zip_of(tmp_path / "m.fmu", *members))


@pytest.mark.parametrize("escape", ESCAPES)
def test_nothing_that_controls_a_terminal_comes_from_a_name(tmp_path, escape):
    assert escape not in printable(f"a{escape}b")
    written = "".join(f"&#{ord(c)};" if c in "\x9b\u202e\r\x7f" else "" for c in escape)
    fmu(tmp_path / "m.fmu", VARIABLE.format(name=f"a{written}b", i=1))
    file = tmp_path / "system.yaml"
    file.write_text(f"{SYSTEM}connections: [{{from: {json.dumps('m.' + escape)}, to: m.x}}]\n")

    for done in (
        answer("inspect", tmp_path / "m.fmu"),
        answer("check", file),
        answer("check", f"no{escape}.yaml"),
        answer("run", file, "--set", f"m.{escape}=1"),
        answer(escape),
    ):
        text = done.output.replace("\r\n", "\n")
        assert not any(c in text for c in "\x1b\x9b\x07\x08\x7f\u202e\r"), repr(text)


@pytest.mark.parametrize("command", ["check", "run", "inspect", "show", "explain", "rerun"])
def test_variables_of_the_environment_stay_names(tmp_path, monkeypatch, command):
    monkeypatch.setenv("SECRET", "hunter2")
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "system.yaml"
    file.write_text(SYSTEM.replace("m.fmu", "${SECRET}/$SECRET.fmu"))

    for given in ("${SECRET}.yaml", "$SECRET", "~/$SECRET.fmu", "system.yaml"):
        assert "hunter2" not in answer(command, given).output


@pytest.mark.parametrize("first", "=+-@")
@pytest.mark.parametrize("place", ["instance", "system"])
def test_no_column_of_a_result_begins_as_a_formula(tmp_path, first, place):
    name = f"{first}cmd|calc!A1"
    text = SYSTEM.replace("  m:", f"  {json.dumps(name)}:") if place == "instance" else SYSTEM
    text = text.replace("name: s", f"name: {json.dumps(name)}") if place == "system" else text
    file = tmp_path / "system.yaml"
    file.write_text(text)

    with pytest.raises(ConfigError, match="a name that a spreadsheet takes for a formula"):
        load_config(file)


def test_an_array_of_objects_is_not_unpickled(tmp_path):
    class Owned:
        def __reduce__(self):
            return (Path(tmp_path / "owned").touch, ())

    np.savez(tmp_path / "x.npz", t=np.array([Owned()], dtype=object))

    with pytest.raises(ValueError, match="allow_pickle=False"):
        read_npz(tmp_path / "x.npz", None)
    assert not (tmp_path / "owned").exists()


@pytest.mark.parametrize("name", ["$\\frac$", "$x^{2}$", "$\\input{/etc/passwd}$", "a$b$c_{"])
def test_a_name_in_a_picture_is_no_formula(name):
    curve = Curve(name, np.arange(3.0), np.arange(3.0))

    assert data_uri(Chart(name, name, name, (curve,))).startswith("data:image/svg+xml")


def test_the_temporary_folder_of_a_command_is_the_users_alone_and_has_no_guessable_name(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    temporary.make()
    [first] = tmp_path.iterdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    temporary.make()
    temporary.remove()

    assert stat.S_IMODE(first.stat().st_mode) == 0o700
    assert len({p.name for p in tmp_path.iterdir()}) == 1
    assert len(first.name.removeprefix("dockloop-")) == 12


def test_what_python_says_of_a_damaged_archive_is_cut(tmp_path):
    path = tmp_path / "m.fmu"
    with zipfile.ZipFile(path, "w") as made:
        made.writestr("modelDescription.xml", description(VARIABLE.format(name="v" * 5000, i=1)))
        made.writestr("resources/large", bytes(60_000))
    data = bytearray(path.read_bytes())
    data[26:28] = struct.pack("<H", 50_000)  # the name in its header reaches over all that follows
    path.write_bytes(data)

    with Archive(path) as opened, pytest.raises(ArchiveError, match="damaged, got File name") as caught:
        opened.read("modelDescription.xml")

    assert len(str(caught.value)) < 1000
