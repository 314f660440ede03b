"""The bill of materials next to the FMUs of a release names each file in each FMU, and what is not ours."""

from __future__ import annotations

import hashlib
import json
import zipfile
from pathlib import Path

from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator

from fmu_sources.bill_of_materials import NAME, bill_of_materials
from fmu_sources.export.places import FMU_FOLDER
from fmu_sources.export.release import differences, release_models, write_release

TEXT = (FMU_FOLDER / NAME).read_text(encoding="utf-8")
BILL = json.loads(TEXT)
FMUS = sorted([*FMU_FOLDER.glob("*.fmu"), *(FMU_FOLDER / "fmi3").glob("*.fmu")])


def sha256(component) -> str:
    [own] = component["hashes"]
    assert own["alg"] == "SHA-256"
    return own["content"]


def components(kind: str) -> dict:
    return {one["name"]: one for one in BILL["components"] if ("components" in one) == (kind == "fmu")}


def test_it_is_one_of_cyclonedx_without_a_time_or_a_machine() -> None:
    assert JsonStrictValidator(SchemaVersion.V1_5).validate_str(TEXT) is None
    assert "timestamp" not in TEXT
    assert "serialNumber" not in TEXT


def test_it_has_the_hash_of_each_fmu_that_the_manifest_has() -> None:
    manifest = json.loads((FMU_FOLDER / "MANIFEST.json").read_text(encoding="utf-8"))["sha256"]

    assert len(manifest) == 2 * len(release_models())
    assert {name: sha256(one) for name, one in components("fmu").items()} == manifest


def test_it_has_the_hash_of_each_file_in_each_fmu() -> None:
    for path in FMUS:
        listed = components("fmu")[path.relative_to(FMU_FOLDER).as_posix()]["components"]
        with zipfile.ZipFile(path) as archive:
            inside = {name: hashlib.sha256(archive.read(name)).hexdigest() for name in archive.namelist()}

        assert {one["name"]: sha256(one) for one in listed} == inside


def test_the_headers_of_fmi_have_their_own_licence_and_each_fmu_depends_on_what_is_foreign() -> None:
    foreign = {one["bom-ref"] for one in components("foreign").values()}
    needs = {one["ref"]: set(one["dependsOn"]) for one in BILL["dependencies"]}

    assert foreign == {"fmi-headers", "compiler-rt", "mingw-w64"}
    for name, fmu in components("fmu").items():
        other = {one["name"] for one in fmu["components"] if "licenses" in one}

        assert {"sources/fmi2Functions.h", "sources/fmi3PlatformTypes.h"} <= other
        assert all(n.startswith("sources/fmi") and n.endswith(".h") for n in other)
        assert needs[name] == foreign


def test_a_release_is_written_with_its_bill_and_a_changed_one_is_found(tmp_path: Path) -> None:
    files = {tmp_path / path.relative_to(FMU_FOLDER): path.read_bytes() for path in FMUS}
    write_release(files, {}, tmp_path)
    bill = tmp_path / NAME

    assert differences(files, {}, tmp_path) == []
    assert bill.read_text(encoding="utf-8") == TEXT

    bill.write_text(TEXT.replace("BSD-2-Clause", "MIT"), encoding="utf-8")

    assert differences(files, {}, tmp_path) == [bill]


def test_it_does_not_depend_on_the_order_of_the_fmus() -> None:
    contents = {path.relative_to(FMU_FOLDER).as_posix(): path.read_bytes() for path in reversed(FMUS)}

    assert bill_of_materials(contents).decode() == TEXT
