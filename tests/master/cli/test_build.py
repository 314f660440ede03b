"""`dockloop build` makes what is missing or stale, and `--check` tells it."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from fmu_sources.bill_of_materials import NAME as BILL
from fmu_sources.export import release
from fmu_sources.export.manifest import NAME, read_manifest
from fmu_sources.export.places import FMU_FOLDER
from master.cli import build as command
from master.cli import main
from tests.stubs.spring import SPRING


def called(*words):
    done = CliRunner().invoke(main, ["build", *map(str, words)])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done


def test_a_model_given_by_its_path_is_built_and_is_stale_when_its_source_changes(tmp_path):
    source, fmus = tmp_path / "spring.py", tmp_path / "fmus"
    fmus.mkdir()
    source.write_text(SPRING, encoding="utf-8")
    missing = called(source, "--output", fmus, "--check")
    built = called(source, "--output", fmus)

    assert missing.exit_code == 2
    assert f"{fmus / 'spring.fmu'}: missing or not what its sources give" in missing.stderr
    assert (built.exit_code, built.stdout.strip()) == (0, str(fmus / "spring.fmu"))
    assert called(source, "--output", fmus, "--check").exit_code == 0

    source.write_text(SPRING.replace("100.0", "200.0"), encoding="utf-8")

    assert called(source, "--output", fmus, "--check").exit_code == 2


def test_released_models_are_what_their_sources_give():
    done = called("force_sensor", "spacecraft", "--check")

    assert (done.exit_code, done.stdout) == (0, "2 FMUs are what their sources give\n")
    assert called("force_sensor").stdout == "0 FMUs built, 1 up to date\n"


def test_a_model_that_is_unknown_is_refused_with_the_nearest_one():
    done = called("force_senser")

    assert done.exit_code == 2
    assert "MODEL: no such model, got 'force_senser'" in done.stderr
    assert "force_sensor" in done.stderr


def test_a_release_holds_all_subsystems():
    done = called("--release", "force_sensor")

    assert done.exit_code == 2
    assert "a release holds all subsystems, got force_sensor" in done.stderr


@pytest.fixture
def released(tmp_path, monkeypatch):
    """A copy of the release whose build gives the committed bytes at once, and is written to the copy."""
    paths = [*FMU_FOLDER.glob("*.fmu"), *(FMU_FOLDER / "fmi3").glob("*.fmu")]
    files = {tmp_path / path.relative_to(FMU_FOLDER): path.read_bytes() for path in paths}
    entries = read_manifest(FMU_FOLDER)
    write, differ = release.write_release, release.differences
    monkeypatch.setattr(release, "release_files", lambda: iter([(files, entries)]))
    monkeypatch.setattr(release, "write_release", lambda f, e: write(f, e, tmp_path))
    monkeypatch.setattr(release, "differences", lambda f, e: differ(f, e, tmp_path))
    monkeypatch.setattr(command, "FMU_FOLDER", tmp_path)
    return tmp_path


def test_a_release_is_written_and_one_changed_byte_of_any_file_is_found(released):
    assert called("--release", "--check").exit_code == 2  # nothing is there

    done = called("--release")

    assert (done.exit_code, done.stdout) == (
        0,
        f"{2 * len(release.release_models())} FMUs of the release written to {released.name}/\n",
    )
    assert (released / NAME).read_bytes() == (FMU_FOLDER / NAME).read_bytes()
    assert (released / BILL).read_bytes() == (FMU_FOLDER / BILL).read_bytes()
    assert called("--release", "--check").exit_code == 0

    for name in ("fmi3/spacecraft.fmu", NAME, BILL):
        path = released / name
        content = path.read_bytes()
        path.write_bytes(content[:-1] + bytes([content[-1] ^ 1]))
        done = called("--release", "--check")
        path.write_bytes(content)

        assert done.exit_code == 2
        assert f"{path}: missing or not what its sources give" in done.stderr
