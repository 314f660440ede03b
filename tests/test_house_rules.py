"""The rules of the house that a machine can check; `reference/style.md` of the project gives the reasons."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[1]
PACKAGES = ("dockloop", "master", "fmu_sources")
SOURCES = sorted(p for package in PACKAGES for p in (PROJECT / package).rglob("*.py"))
NAMES = {str(p.relative_to(PROJECT)): p for p in SOURCES}

MEETING_PLACES = (
    "master/catalogue.py",
    "master/cli/build.py",
    "master/cli/doctor.py",
    "master/installation.py",  # where the shipped files are
    "master/diagnosis/",
    "master/fmi/unit_names.py",  # the one unit parser is that which writes the FMUs' units
    "master/fuse/",  # compiles the sources inside FMUs with the wrapper that they were written with
)

Function = ast.FunctionDef | ast.AsyncFunctionDef

each_source = pytest.mark.parametrize("name", NAMES)


def tree_of(name: str) -> ast.Module:
    return ast.parse(NAMES[name].read_text(encoding="utf-8"))


def public(nodes: list[ast.stmt]) -> Iterator[Function | ast.ClassDef]:
    for node in nodes:
        if isinstance(node, (Function, ast.ClassDef)) and not node.name.startswith("_"):
            yield node


@cache
def documented_methods() -> set[str]:
    """Names of methods that have a docstring somewhere: an override needs none of its own."""
    classes = (n for name in NAMES for n in ast.walk(tree_of(name)) if isinstance(n, ast.ClassDef))
    return {f.name for c in classes for f in public(c.body) if ast.get_docstring(f)}


DOCUMENTED_ELSEWHERE = {"Protocol", "Fmi2Slave"}  # the class says it for all members; PythonFMU's class


def methods_to_document(c: ast.ClassDef) -> Iterator[Function | ast.ClassDef]:
    bases = {ast.unparse(base).rpartition(".")[2] for base in c.bases}
    if not bases & DOCUMENTED_ELSEWHERE:
        yield from (m for m in public(c.body) if m.name not in documented_methods())


@each_source
def test_no_bare_exception_is_raised(name):
    raised = [n.exc for n in ast.walk(tree_of(name)) if isinstance(n, ast.Raise) and n.exc]
    names = [ast.unparse(e.func if isinstance(e, ast.Call) else e) for e in raised]

    assert "Exception" not in names
    assert "BaseException" not in names


@each_source
def test_the_library_does_not_print(name):
    calls = [n.func for n in ast.walk(tree_of(name)) if isinstance(n, ast.Call)]

    assert [f.id for f in calls if isinstance(f, ast.Name) and f.id == "print"] == []


@each_source
def test_no_star_imports(name):
    imports = [n for n in ast.walk(tree_of(name)) if isinstance(n, ast.ImportFrom)]

    assert [n.module for n in imports if n.names[0].name == "*"] == []


@each_source
def test_every_public_thing_has_a_docstring(name):
    tree = tree_of(name)
    missing = [] if ast.get_docstring(tree) or not tree.body else ["module"]
    for thing in public(tree.body):
        missing += [] if ast.get_docstring(thing) else [thing.name]
        methods = methods_to_document(thing) if isinstance(thing, ast.ClassDef) else ()
        missing += [f"{thing.name}.{m.name}" for m in methods if not ast.get_docstring(m)]

    assert missing == []


def imported(name: str) -> set[str]:
    found = set()
    for node in ast.walk(tree_of(name)):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found.add(str(node.module).partition(".")[0])
    return found


@each_source
def test_master_and_fmu_sources_meet_at_the_fmu_file(name):
    if name.startswith("dockloop"):
        return  # it is over both
    other = "fmu_sources" if name.startswith("master") else "master"
    if not name.startswith(MEETING_PLACES):
        assert other not in imported(name)


HOMES = "|".join(("work", "root", "home", "opt", "Users", "tmp"))
MACHINE_PATH = re.compile(rf"(?<![\w.:/~$}}-])/(?:{HOMES})/\w+")
TEXT = {".py", ".md", ".yaml", ".yml", ".toml", ".c", ".h", ".json", ".txt", ".xml", ".sh", ".cfg", ""}


def text_files() -> Iterator[Path]:
    tops = [p for p in PROJECT.iterdir() if p.name in (".ci", ".github") or not p.name.startswith(".")]
    for top in tops:
        for path in [top] if top.is_file() else top.rglob("*"):
            inside = path.relative_to(PROJECT).parts
            skipped = {"__pycache__", "results", "build", "dist", ".venv", "venv"} & set(inside)
            if path.is_file() and not skipped and path.suffix in TEXT:
                yield path


def test_no_file_names_a_folder_of_one_machine():
    found = {
        f"{path.relative_to(PROJECT)}: {match[0]}"
        for path in text_files()
        for match in MACHINE_PATH.finditer(path.read_text(encoding="utf-8", errors="ignore"))
    }

    assert found == set()
