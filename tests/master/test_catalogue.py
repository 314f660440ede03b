from pathlib import Path

import pytest

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
    assert catalogue.file_of(tmp_path / "mass.fmu") == tmp_path / "mass.fmu"


def test_a_folder_is_not_an_fmu(tmp_path):
    (tmp_path / "mass.fmu").mkdir()

    with pytest.raises(ConfigError, match=r"no such file, got 'mass\.fmu', expected an FMU at "):
        catalogue.locate("mass.fmu", tmp_path, "python")


@pytest.mark.parametrize("flavour", ["native", "python", "fmi3"])
def test_a_model_has_a_file_to_be_for_each_flavour(tmp_path, flavour):
    target = catalogue.locate("spacecraft", tmp_path, flavour)

    assert (target.model, target.flavour) == ("spacecraft", flavour)
    assert catalogue.file_of(target).name == "spacecraft.fmu"


class Target:
    def __init__(self, path, current):
        self.path, self.model, self.current = Path(path), Path(path).stem, current

    def is_current(self):
        return self.current


def test_what_is_stale_is_built_once_and_said_so(monkeypatch):
    built, said = [], []
    monkeypatch.setattr(catalogue.build, "Target", Target)
    monkeypatch.setattr(catalogue.build, "build", built.append)
    old, fresh = Target("old.fmu", False), Target("fresh.fmu", True)

    catalogue.build_stale([old, fresh, Path("own.fmu"), old], said.append)

    assert (built, said) == ([old], ["old"])
