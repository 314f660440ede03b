import os
import stat
import struct
import zipfile
from pathlib import Path

import pytest

from master.text.archive import Archive, ArchiveError, NotAnArchiveError


def packed(folder, members, method=zipfile.ZIP_DEFLATED):
    path = folder / "a.zip"
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return path


def patched(path, local, central, value):
    """Change two bytes in the local and in the central header of the first member."""
    content = bytearray(path.read_bytes())
    second = content.index(b"PK\x01\x02")
    content[local : local + 2] = content[second + central : second + central + 2] = struct.pack("<H", value)
    path.write_bytes(content)
    return path


def fault(path, name=None):
    with pytest.raises(ArchiveError) as caught, Archive(path) as archive:
        archive.read(name or archive.names[0])
    return str(caught.value)


@pytest.mark.parametrize(
    "method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA]
)
def test_members_are_read_whatever_python_can_unpack(tmp_path, method):
    path = packed(tmp_path, {"a.txt": "text" * 100, "b/c.txt": "more"}, method)
    with Archive(path) as archive:
        assert archive.names == ["a.txt", "b/c.txt"]
        assert archive.read("a.txt") == b"text" * 100


def test_backslashes_separate_folders(tmp_path):
    path = packed(tmp_path, {"b\\": "", "b\\c.txt": "more"})
    with Archive(path) as archive:
        assert archive.names == ["b/c.txt"]
        folder = archive.unpacked(lambda name: True)
    assert (folder / "b" / "c.txt").read_text() == "more"


def test_a_name_that_begins_with_a_dot_and_a_slash_is_one_without(tmp_path):
    with Archive(packed(tmp_path, {"./b/./c.txt": "more"})) as archive:
        assert archive.read("b/c.txt") == b"more"


def test_a_folder_is_read_as_its_archive_is(tmp_path):
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "c.txt").write_text("more")
    with Archive(tmp_path) as archive:
        assert (archive.names, archive.read("b/c.txt")) == (["b/c.txt"], b"more")


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("../out.txt", "leads out of the archive"),
        ("a/../../out.txt", "leads out of the archive"),
        ("..\\out.txt", "leads out of the archive"),
        ("/etc/out.txt", "an absolute name"),
        ("C:\\out.txt", "an absolute name"),
        ("\\\\host\\out.txt", "an absolute name"),
    ],
)
def test_a_name_that_leads_out_is_refused(tmp_path, name, problem):
    path = packed(tmp_path, {"a.txt": "text", name: "text"})

    assert fault(path) == f"member {name!r}: {problem}, expected a name inside the archive"


def test_a_link_is_refused(tmp_path):
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w") as archive:
        info = zipfile.ZipInfo("link")
        info.create_system = 3
        info.external_attr = (stat.S_IFLNK | 0o777) << 16
        archive.writestr(info, "/etc/passwd")

    assert fault(path) == "member 'link': a link, expected a name inside the archive"


def test_a_link_out_of_a_folder_is_refused(tmp_path):
    folder = tmp_path / "fmu"
    folder.mkdir()
    os.symlink(tmp_path, folder / "link")

    assert fault(folder).startswith("link: leads out of the folder, got a link to ")


def test_a_member_that_is_there_twice_is_refused_where_the_contents_differ(tmp_path):
    path = packed(tmp_path, {"b/c.txt": "one", "b\\c.txt": "two"})
    assert fault(path) == "b/c.txt: twice in the archive with different contents, expected one"

    path = packed(tmp_path, {"b/c.txt": "one", "b\\c.txt": "one"})
    with Archive(path) as archive:
        assert (archive.names, archive.read("b/c.txt")) == (["b/c.txt"], b"one")


def test_a_file_that_is_a_folder_too_is_refused(tmp_path):
    assert fault(packed(tmp_path, {"b": "one", "b/c.txt": "two"})) == "member 'b': a file and a folder"
    assert fault(packed(tmp_path, {"a/./b": "one", "a//b/c/d.txt": "two"})) == (
        "member 'a/b': a file and a folder"
    )


def test_an_encrypted_member_is_refused_by_name(tmp_path):
    path = patched(packed(tmp_path, {"a.txt": "text"}), 6, 8, 1)

    assert fault(path) == "a.txt: encrypted, expected a member that is readable without a password"


@pytest.mark.parametrize(("method", "name"), [(9, "Deflate64"), (93, "Zstandard"), (99, "AES encryption")])
def test_a_method_that_cannot_be_read_is_refused_by_name(tmp_path, method, name):
    path = patched(packed(tmp_path, {"a.txt": "text"}), 8, 10, method)

    assert fault(path) == (
        f"a.txt: packed by a method that cannot be read, got {name} ({method}), expected Deflate or none"
    )


@pytest.mark.parametrize("method", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_a_damaged_member_is_refused_by_name_and_leaves_no_folder(tmp_path, method, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    path = packed(tmp_path, {"a.txt": bytes(range(256)) * 10}, method)
    content = bytearray(path.read_bytes())
    for i in range(45, 75):
        content[i] ^= 0x5A
    path.write_bytes(content)

    assert fault(path).startswith("a.txt: damaged, got ")
    with pytest.raises(ArchiveError, match="damaged"), Archive(path) as archive:
        archive.unpacked(lambda name: True)
    assert list((tmp_path / "temporary").iterdir()) == []


def test_every_cut_of_an_archive_is_refused_without_any_other_error(tmp_path):
    whole = packed(tmp_path, {"a.txt": "text" * 20, "b.txt": "more"}).read_bytes()
    for n in range(len(whole)):
        (tmp_path / "a.zip").write_bytes(whole[:n])
        with pytest.raises(ArchiveError), Archive(tmp_path / "a.zip") as archive:
            archive.read("a.txt"), archive.read("b.txt")


def test_every_changed_byte_gives_the_content_or_an_archive_error(tmp_path):
    path = packed(tmp_path, {"a.txt": "text" * 20})
    whole = path.read_bytes()
    for i in range(len(whole)):
        changed = bytearray(whole)
        changed[i] ^= 0xFF
        path.write_bytes(changed)
        try:
            with Archive(path) as archive:
                for name in archive.names:
                    assert archive.read(name) == b"text" * 20
        except ArchiveError:
            pass


def test_a_file_that_is_no_archive_has_an_error_of_its_own(tmp_path):
    (tmp_path / "a.zip").write_text("text")
    with pytest.raises(NotAnArchiveError):
        Archive(tmp_path / "a.zip")
    with pytest.raises(FileNotFoundError):
        Archive(Path(tmp_path / "none.zip"))
