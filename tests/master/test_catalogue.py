from pathlib import Path
from types import SimpleNamespace

import pytest

from fmu_sources.export import build
from fmu_sources.export.native import MissingToolError
from master import catalogue
from master.errors import ConfigError


@pytest.mark.parametrize("source", ["mass.fmu", "../mass", "fmus/mass.fmu", "C:\\fmus\\mass"])
def test_a_source_with_a_suffix_or_a_folder_is_a_path(source):
    assert catalogue.is_path(source)


def test_a_source_that_is_a_word_is_a_model():
    assert not catalogue.is_path("spacecraft")


def test_a_path_starts_from_the_folder_of_the_file(tmp_path):
    (tmp_path / "mass.fmu").touch()

    assert catalogue.locate("mass.fmu", tmp_path, "python") == tmp_path / "mass.fmu"


def test_a_folder_is_not_an_fmu(tmp_path):
    (tmp_path / "mass.fmu").mkdir()

    with pytest.raises(ConfigError, match=r"no such file, got 'mass\.fmu', expected an FMU at "):
        catalogue.locate("mass.fmu", tmp_path, "python")


@pytest.mark.parametrize("name", ["mass.FMU", "unpacked.fmu", "./unpacked"])
def test_a_suffix_in_capitals_and_an_unpacked_folder_are_fmus(tmp_path, name):
    if name == "mass.FMU":
        (tmp_path / name).write_bytes(b"")
    else:
        (tmp_path / name).mkdir()
        (tmp_path / name / "modelDescription.xml").write_text("<a/>")

    assert catalogue.locate(name, tmp_path, "python") == tmp_path / name


@pytest.mark.parametrize("flavour", ["native", "python", "fmi3"])
def test_a_model_has_a_file_to_be_for_each_flavour(tmp_path, flavour):
    target = catalogue.locate("spacecraft", tmp_path, flavour)

    assert (target.model, target.flavour) == ("spacecraft", flavour)
    assert target.path.name == "spacecraft.fmu"


@pytest.fixture
def targets(tmp_path, monkeypatch):
    """Make targets that are built by writing their flavour; `failing` ones lack a tool when native."""
    built = []

    def made(name, *, current=False, flavour="native"):
        target = build.Target(name, flavour, tmp_path / flavour / f"{name}.fmu", "token")
        monkeypatch.setattr(build.Target, "is_current", lambda t: t.model in current_models)
        if current:
            current_models.add(name)
        return target

    def building(target):
        if target.model.startswith("failing") and target.flavour != "python":
            raise MissingToolError("casadi")
        built.append((target.model, target.flavour))
        return target.path

    current_models: set[str] = set()
    monkeypatch.setattr(build, "build", building)
    monkeypatch.setattr(build, "target", lambda name, flavour: made(name, flavour=flavour))
    return SimpleNamespace(made=made, built=built)


def test_what_is_stale_is_built_once_and_said_so(targets):
    said = []
    old, fresh = targets.made("old"), targets.made("fresh", current=True)

    found = catalogue.files({"a": old, "b": fresh, "c": Path("own.fmu"), "d": old}, said.append)

    assert found == {"a": old.path, "b": fresh.path, "c": Path("own.fmu"), "d": old.path}
    assert (targets.built, said) == ([("old", "native")], ["building old.fmu (native)"])


def test_a_native_fmu_that_cannot_be_built_here_gives_way_to_the_python_flavour(targets):
    said = []
    found = catalogue.files({"a": targets.made("failing")}, said.append)

    assert found["a"].parent.name == "python"
    assert targets.built == [("failing", "python")]
    assert said[1].startswith("native build: casadi is not installed, expected: pip install")


def test_an_fmi_3_fmu_that_cannot_be_built_here_is_an_error(targets):
    with pytest.raises(
        ConfigError, match=r"failing\.fmu: missing or older than its sources; native build: casadi"
    ):
        catalogue.files({"a": targets.made("failing", flavour="fmi3")}, catalogue.silent)


def test_a_path_with_a_character_that_cannot_be_seen_is_shown_with_its_number():
    with pytest.raises(ConfigError) as caught:
        catalogue.locate("integra\ufefftor.fmu", Path("fmus"), "native")

    escaped = r"integra\ufefftor.fmu"
    assert caught.value.problems == [
        f"no such file, got '{escaped}', expected an FMU at {Path('fmus') / escaped}"
    ]
