"""The wheel is reproducible; the bill of materials names all that a run loads."""

from __future__ import annotations

import hashlib
import json
import zipfile

import pytest
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator

from tests.reliability.packages import PROJECT, bill_of_materials, digest, oldest, requirements, wheel


def test_the_bill_of_materials_names_every_dependency_with_its_version():
    bill = bill_of_materials()
    names = {one["name"].lower() for one in bill["components"]}

    assert {name.lower() for name, _ in requirements()} <= names
    assert "llvmlite" in names  # that numba needs
    assert all(one["version"] and one["licenses"][0]["license"]["name"] for one in bill["components"])


def test_every_dependency_has_a_lower_bound_that_can_be_installed():
    found = oldest(requirements())

    assert "numpy==2.1.3" in found
    assert "lxml~=5.3.0" in found
    assert "fmpy==0.3.26" in found
    assert len(found) == len(requirements())
    assert "casadi==3.6.7" in oldest(requirements("native"))


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    return wheel(tmp_path_factory.mktemp("wheel"))


@pytest.mark.long
def test_the_wheel_built_twice_has_the_same_bytes(built, tmp_path):
    assert digest(built) == digest(wheel(tmp_path))


@pytest.mark.long
def test_the_wheel_holds_a_bill_of_its_files_and_requirements_without_a_time_or_a_machine(built):
    with zipfile.ZipFile(built) as archive:
        [name] = [one for one in archive.namelist() if one.endswith(".dist-info/sboms/dockloop.cdx.json")]
        text = archive.read(name).decode()
        inside = {n: hashlib.sha256(archive.read(n)).hexdigest() for n in archive.namelist()}
    bill = json.loads(text)
    shipped = {
        one["name"]: one["hashes"][0]["content"] for one in bill["components"] if one["type"] == "file"
    }
    libraries = {one["name"] for one in bill["components"] if one["type"] == "library"}

    assert JsonStrictValidator(SchemaVersion.V1_5).validate_str(text) is None
    assert shipped == {n: content for n, content in inside.items() if ".dist-info/" not in n}
    assert libraries == {one for one, _ in requirements()}
    released = json.loads((PROJECT / "fmus" / "MANIFEST.json").read_text(encoding="utf-8"))["sha256"]
    assert {f"dockloop/fmus/{n}": content for n, content in released.items()}.items() <= shipped.items()
    assert "timestamp" not in text
    assert "serialNumber" not in text
