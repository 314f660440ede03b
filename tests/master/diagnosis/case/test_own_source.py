"""A model of one's own by the path of its file, from the folder of a case."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import fmu_sources
from fmu_sources.composed import registry
from fmu_sources.export.own_model import OwnModelError, added, load_model
from fmu_sources.framework.instance import Instance
from master.cli import main
from master.errors import ConfigError

RIG = '''"""Specimen on a spring: F = k q + c q' (slot `force`)."""

from own_numbers import STIFFNESS

from fmu_sources.framework.model import Model, Slot, no_effect
from fmu_sources.framework.variables import declare, input_, output, parameter


class {cls}(Model):
    """See the module's text."""

    name = "{name}"
    description = "Specimen on a spring."
    variables = declare(
        parameter("stiffness", STIFFNESS, "N/m", "Stiffness k", above=0.0),
        parameter("damping", 5.0, "N s/m", "Damping c", minimum=0.0),
        input_("q", "m", "Position"),
        input_("der_q", "m/s", "Velocity"),
        output("force", "N", "Force"),
        {more}
    )
    slots = (Slot("law", "N", "Force of the specimen", {{"q": "m", "der_q": "m/s"}}),)

    def outputs(self, t, x, u, p, m, slot=no_effect):
        """Return the force."""
        return {{"force": slot("law", p.stiffness * u.q + p.damping * u.der_q, q=u.q, der_q=u.der_q)}}


MODEL = {cls}()
'''
CASE = """name: of_its_own
fmus:
  rig: {{source: {source}}}
recordings: {{run: run.csv}}
time: {{column: t}}
signals:
  q: {{column: q, unit: m}}
  der_q: {{column: v, unit: m/s}}
  force: {{column: f, unit: N}}
inputs:
  rig.q: {{signal: q, at: end}}
  rig.der_q: {{signal: der_q, at: end}}
compared: {{rig.force: force}}
refit:
  rig.stiffness: {{low: 100, high: 1000}}
  rig.damping: {{low: 0, high: 50}}
slots: {{rig.law: [coulomb, quadratic_damping]}}
split:
  blocks: [{blocks}]
"""
BLOCKS = ", ".join(["fit", "select"] * 6 + ["sealed", "fit", "select", "sealed"])
COULOMB = 4.0  # N


def written(folder: Path, name: str, more: str = "", source: str | None = None) -> Path:
    """Write a rig, what it imports, its recording with dry friction and 20 mN of noise, and a case."""
    (folder / "own_numbers.py").write_text("STIFFNESS = 250.0\n")
    (folder / f"{name}.py").write_text(RIG.format(name=name, cls=name.title().replace("_", ""), more=more))
    t = np.arange(4000) * 2e-3
    q = 0.05 * np.sin(2.0 * np.pi * 0.7 * t) + 0.02 * np.sin(2.0 * np.pi * 1.9 * t + 1.0)
    v = 0.07 * np.pi * np.cos(2.0 * np.pi * 0.7 * t) + 0.076 * np.pi * np.cos(2.0 * np.pi * 1.9 * t + 1.0)
    noise = 0.02 * np.random.default_rng(4).standard_normal(len(t))
    rows = np.column_stack([t, q, v, 300.0 * q + 6.0 * v + COULOMB * np.sign(v) + noise])
    np.savetxt(folder / "run.csv", rows, delimiter=",", header="t,q,v,f", comments="")
    case = folder / "case.yaml"
    case.write_text(CASE.format(source=source or f"{name}.py", blocks=BLOCKS))
    return case


def files_of_the_package():
    root = Path(fmu_sources.__file__).parent
    return {
        (p, p.stat().st_mtime_ns) for p in root.rglob("*") if p.is_file() and "__pycache__" not in p.parts
    }


def checked(case, *options):
    return CliRunner().invoke(main, ["check", str(case), *options])


def test_a_case_takes_its_model_from_a_file_next_to_it_and_writes_nothing_to_the_package(
    tmp_path, monkeypatch
):
    monkeypatch.setattr("fmu_sources.export.build.cache_folder", lambda: tmp_path / "cache")
    before = files_of_the_package()
    case = written(tmp_path, "own_specimen")
    monkeypatch.chdir("/")

    done = checked(case, "--json")

    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["parts"] == [
        {"fmus": "rig", "compared": ["rig.force"], "effects": 2},
    ]
    assert files_of_the_package() == before
    assert len(list((tmp_path / "cache" / "fmus" / "native").rglob("own_specimen.fmu"))) == 1


@pytest.mark.parametrize(
    ("more", "old", "new", "line", "message"),
    [
        (
            'output("coupling", "N", "Other force"),',
            "",
            "",
            None,
            "output 'coupling' is declared, and outputs() does not return it",
        ),
        (
            "",
            '{"force": slot',
            '{"forces": slot',
            None,
            "outputs() returns 'forces', expected a declared output",
        ),
        ("", "u.q + p", "u.position + p", 26, "AttributeError: "),
        ("", "return {", "return [", 26, "closing parenthesis"),
        ("", "return {", "{", None, "outputs(), got NoneType, expected a mapping of names to values"),
        ("", "MODEL = ", "OTHER = ", None, "MODEL: not a model, got nothing"),
        ("", "import STIFFNESS", "import DAMPING", 3, "ImportError: "),
        ("", 'name = "wrong', 'name = "two words', None, "name of the model, got 'two words"),
        ("", "from own_numbers", "raise SystemExit(0)\nfrom own_numbers", 3, "SystemExit: 0"),
        ("", "return {", "import sys; sys.exit(0); return {", 26, "SystemExit: 0"),
        ("", "MODEL = ", "\0MODEL = ", None, "source code string cannot contain null bytes"),
        ("", "return {", "raise ValueError('no\\nforce'); return {", 26, "ValueError: no force"),
        ("", "return {", "eval('1 +'); return {", 26, "invalid syntax"),
    ],
)
def test_a_mistake_in_ones_own_model_is_told_with_file_and_line(more, old, new, line, message, tmp_path):
    case = written(tmp_path, "wrong_specimen", more)
    rig = tmp_path / "wrong_specimen.py"
    rig.write_text(rig.read_text().replace(old, new, 1))

    done = checked(case)

    assert done.exit_code == 2, done.output
    at = f"{rig}:{line}: " if line else f"{rig}: "
    assert done.stderr.startswith(f"{case}:3: fmus.rig.source: {at}"), done.stderr
    assert message in done.stderr


def test_what_a_model_prints_while_it_is_loaded_and_checked_does_not_reach_standard_output(tmp_path, capsys):
    written(tmp_path, "talking_specimen")
    rig = tmp_path / "talking_specimen.py"
    talking = rig.read_text().replace("return {", "print('checked'); return {", 1)
    rig.write_text(f"{talking}\nprint('loaded')\n")

    added(rig)

    said = capsys.readouterr()
    assert said.out == ""
    assert {"loaded", "checked"} <= set(said.err.split())


def test_what_models_print_while_a_case_is_checked_is_no_part_of_the_answer_as_data(tmp_path, monkeypatch):
    def talking(path, progress):
        sys.stdout.write("traced\n")
        raise ConfigError(["wrong"])

    monkeypatch.setattr("master.diagnosis.judge.checked.check_case", talking)

    done = checked(written(tmp_path, "traced_specimen"), "--json")

    assert json.loads(done.stdout) == {"status": "failed", "problems": ["wrong"]}
    assert done.stderr.splitlines() == ["traced", "wrong"]


def newly_imported(folder: Path, module: str) -> set[str]:
    """Load a model that imports a module, too; return the names that stay known, and forget them."""
    name = f"model_in_{folder.name.replace('-', '_')}"
    written(folder, name)
    rig = folder / f"{name}.py"
    rig.write_text(rig.read_text().replace("from own_numbers", f"import {module}\nfrom own_numbers", 1))
    before = set(sys.modules)
    load_model(rig)
    found = set(sys.modules) - before
    for imported in found:
        del sys.modules[imported]
    return {n for n in found if not n.startswith("dockloop_model_")}


def package(folder: Path, *files: str) -> None:
    """Write empty modules into a folder."""
    folder.mkdir(parents=True)
    for file in files:
        (folder / file).touch()


def test_a_library_installed_below_the_folder_of_a_model_stays_imported(tmp_path, monkeypatch):
    installed = tmp_path / ".venv" / "lib" / "site-packages"
    package(installed / "own_library", "__init__.py", "part.py")
    monkeypatch.syspath_prepend(str(installed))

    assert newly_imported(tmp_path, "own_library.part") == {"own_library", "own_library.part"}


def test_libraries_around_a_model_that_is_installed_stay_imported(tmp_path):
    package(tmp_path / "site-packages", "library_around.py")

    found = newly_imported(tmp_path / "site-packages", "library_around")

    assert found == {"library_around", "own_numbers"}


@pytest.mark.parametrize("files", [["__init__.py", "spring.py"], ["spring.py"]])
def test_packages_in_the_folder_of_a_model_are_imported_by_it_alone(files, tmp_path):
    package(tmp_path / "own_parts", *files)

    assert newly_imported(tmp_path, "own_parts.spring") == set()


def test_files_next_to_models_of_two_folders_may_have_one_name(tmp_path):
    stiffness = {}
    for name, value in (("first_of_two", "250.0"), ("second_of_two", "700.0")):
        folder = tmp_path / name
        folder.mkdir()
        written(folder, name)
        (folder / "own_numbers.py").write_text(f"STIFFNESS = {value}\n")
        stiffness[name] = Instance(load_model(folder / f"{name}.py"))["stiffness"]

    assert stiffness == {"first_of_two": 250.0, "second_of_two": 700.0}


def test_a_name_that_another_model_has_is_refused(tmp_path):
    case = written(tmp_path, "oscillator")

    done = checked(case)

    assert done.exit_code == 2
    assert "name of the model is taken, got 'oscillator', also in " in done.stderr


def test_a_model_whose_file_was_moved_is_taken_from_its_new_place(tmp_path):
    written(tmp_path, "moved_specimen")
    added(tmp_path / "moved_specimen.py")
    moved = (tmp_path / "moved_specimen.py").rename(tmp_path / "moved.py")

    added(moved)

    assert registry.modules("moved_specimen") == (moved,)


def test_a_model_of_another_working_folder_is_another_one(tmp_path, monkeypatch):
    for folder in (tmp_path / "first", tmp_path / "second"):
        folder.mkdir()
        written(folder, "relative_specimen")
    monkeypatch.chdir(tmp_path / "first")
    added(Path("relative_specimen.py"))
    monkeypatch.chdir(tmp_path / "second")

    with pytest.raises(OwnModelError, match="name of the model is taken"):
        added(Path("relative_specimen.py"))


def test_a_file_that_is_not_there_is_refused(tmp_path):
    done = checked(written(tmp_path, "there", source="not_there.py"))

    assert done.exit_code == 2
    assert f"{tmp_path / 'not_there.py'}: no such file" in done.stderr


@pytest.mark.long
def test_what_a_model_of_ones_own_lacks_is_named_and_its_corrected_system_runs(tmp_path):
    case = written(tmp_path, "lacking_specimen")
    out = tmp_path / "out"

    done = CliRunner().invoke(main, ["diagnose", str(case), "--output", str(out), "--json"])

    assert done.exit_code == 0, done.output
    report = json.loads(done.stdout)
    assert report["effects"][0]["effect"] == "coulomb"
    ran = CliRunner().invoke(
        main, ["run", str(out / "of_its_own_corrected.yaml"), "--output", str(tmp_path / "run")]
    )
    assert ran.exit_code == 0, ran.output
