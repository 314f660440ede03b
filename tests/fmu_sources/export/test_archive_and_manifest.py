from __future__ import annotations

import hashlib
import io
import struct
import zipfile
import zlib

from fmu_sources.export.archive import pack
from fmu_sources.export.icon import SIZE, icon_png
from fmu_sources.export.manifest import NAME, Entry, manifest, read_manifest

FILES = {"sources/b.c": b"b", "modelDescription.xml": b"<fmi/>", "binaries/a.so": b"a" * 1000}


def test_an_archive_depends_on_its_contents_only_and_begins_with_the_description():
    packed = pack(FILES)
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        entries = archive.infolist()
        contents = {entry.filename: archive.read(entry) for entry in entries}

    assert packed == pack(dict(reversed(FILES.items())))
    assert [e.filename for e in entries] == ["modelDescription.xml", "binaries/a.so", "sources/b.c"]
    assert {e.date_time for e in entries} == {(2026, 1, 1, 0, 0, 0)}
    assert {e.external_attr >> 16 for e in entries} == {0o100644}
    assert contents == FILES


def test_a_manifest_is_read_as_it_was_written(tmp_path):
    entries = {"b": Entry("{s}", "c", "{t}"), "a": Entry("{1}", "2", "{3}")}
    files = {tmp_path / "fmi3" / "a.fmu": b"three", tmp_path / "a.fmu": b"two"}
    (tmp_path / NAME).write_bytes(manifest(files, entries, tmp_path))

    assert read_manifest(tmp_path) == entries
    assert hashlib.sha256(b"three").hexdigest() in (tmp_path / NAME).read_text()
    assert '"fmi3/a.fmu"' in (tmp_path / NAME).read_text()


def test_no_release_has_no_models(tmp_path):
    assert read_manifest(tmp_path) == {}


def test_an_icon_is_a_png_that_is_symmetric_and_belongs_to_a_name():
    content = icon_png("spacecraft")
    assert content.startswith(b"\x89PNG\r\n\x1a\n")
    width, height = struct.unpack(">II", content[16:24])
    start = content.index(b"IDAT")
    (length,) = struct.unpack(">I", content[start - 4 : start])
    pixels = zlib.decompress(content[start + 4 : start + 4 + length])
    rows = [pixels[y * (3 * SIZE + 1) + 1 : (y + 1) * (3 * SIZE + 1)] for y in range(SIZE)]
    inner = [[row[3 * x : 3 * x + 3] for x in range(2, SIZE - 2)] for row in rows[2:-2]]

    assert (width, height) == (SIZE, SIZE)
    assert any(len(set(row)) > 1 for row in inner)
    assert all(row == row[::-1] for row in inner)
    assert content == icon_png("spacecraft") != icon_png("compensator")
