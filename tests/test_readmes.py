"""Each package has a README whose table names its files and folders, and what each uses where it says so."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[1]
PACKAGES = sorted(
    path.parent
    for top in ("dockloop", "master", "fmu_sources")
    for path in (PROJECT / top).rglob("__init__.py")
)
NAMES = [str(p.relative_to(PROJECT)) for p in PACKAGES]


def rows(package: str) -> list[list[str]]:
    readme = PROJECT / package / "README.md"
    lines = readme.read_text(encoding="utf-8").splitlines() if readme.is_file() else []
    cells = ([c.strip() for c in line.strip("|").split(" | ")] for line in lines if line.startswith("|"))
    return list(cells)


def named(package: str) -> set[str]:
    """Names in the first column: files, and folders with or without a slash."""
    return {name.strip("/") for row in rows(package) for name in re.findall(r"`([^`]+)`", row[0])}


def content(package: str) -> set[str]:
    folder = PROJECT / package
    files = {p.name for p in folder.glob("*.py") if p.name != "__init__.py"}
    return files | {p.parent.name for p in folder.glob("*/__init__.py")}


def imported(path: Path) -> set[str]:
    """Modules that a file imports: of its own folder by name, of other packages as `master.package`."""
    package = ".".join(path.relative_to(PROJECT).parts[:-1])
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level <= 1:
            module = f"{package}.{node.module or ''}".rstrip(".") if node.level else str(node.module)
            inside = module.removeprefix(package).strip(".") if module.startswith(package) else None
            if inside is None:
                parts = module.split(".")
                found.add(".".join(parts[:2]) if parts[0] == "master" else parts[0])
            else:
                found |= {inside.partition(".")[0]} if inside else {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):  # further up, by the package there
            found.add(str(node.module).partition(".")[0])
    return found


@pytest.mark.parametrize("package", NAMES)
def test_the_readme_of_a_package_names_all_of_its_files_and_none_that_is_not_there(package):
    files = {name for name in named(package) if name.endswith(".py")}

    assert content(package) - named(package) == set()
    assert files - {p.name for p in (PROJECT / package).rglob("*.py")} == set()


@pytest.mark.parametrize("package", [n for n in NAMES if ["file", "what it does", "uses"] in rows(n)])
def test_what_a_file_uses_is_what_it_imports(package):
    wrong = {}
    for name, _, uses in (row for row in rows(package) if len(row) == 3 and row[0].endswith(".py`")):
        path = PROJECT / package / name.strip("`")
        told = set(re.findall(r"`([^`]+)`", uses))
        if not told <= imported(path):
            wrong[name] = told - imported(path)

    assert wrong == {}
