"""
Models by name: `<folder>/<name>.py` holds the model `name` as `MODEL`; others are composed by their name.

Models of files elsewhere are added by `add` while the program runs.

A folder of models says in its `__init__.py` whether the release holds them, `RELEASED = True` or `False`:
that line makes it one, and nothing else lists it.
"""

from __future__ import annotations

import ast
import importlib
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

from ..framework.model import Model
from .names import base_of, composed, effects_of, is_composed

ROOT = Path(__file__).parents[1]
_DECLARATION = re.compile(r"^RELEASED = (True|False)$", re.MULTILINE)


class _Own(NamedTuple):
    """A model that is not of this package, and the file that defines it."""

    model: Model
    file: Path


_own: dict[str, _Own] = {}


def model_files() -> dict[str, Path]:
    """Map the name of each model of this package to its file, folders and files in alphabetical order."""
    return dict(_found())


def add(model: Model, file: Path) -> None:
    """
    Make a model of a file elsewhere known by its name, in the place of an earlier one of that file.

    It also takes the place of one whose file is there no longer, as after that was renamed.

    Raises:
        ValueError: If the name is taken by another file.
    """
    known = _own.get(model.name)
    other = known.file if known is not None else _found().get(model.name)
    if other is not None and other.exists() and not other.samefile(file):
        raise ValueError(f"name of the model is taken, got {model.name!r}, also in {other}, expected another")
    _own[model.name] = _Own(model, file.absolute())
    _composed.cache_clear()


def is_own(name: str) -> bool:
    """Whether a model, or the one that it is composed of, was added from a file elsewhere."""
    return base_of(name) in _own


def is_released(name: str) -> bool:
    """Whether the folder of a model says that the release holds it; KeyError if there is none."""
    return bool(_released(model_files()[name].parent))


@cache
def _found() -> Mapping[str, Path]:
    folders = sorted(path.parent for path in ROOT.glob("*/__init__.py") if _released(path.parent) is not None)
    found: dict[str, Path] = {}
    for path in (path for folder in folders for path in sorted(folder.glob("*.py")) if _holds_model(path)):
        if path.stem in found:
            raise ValueError(f"{path}: model name is taken, got {path.stem!r}, also in {found[path.stem]}")
        found[path.stem] = path
    return found


def _released(folder: Path) -> bool | None:
    """What a folder declares; None if it is no folder of models."""
    declared = _DECLARATION.search((folder / "__init__.py").read_text(encoding="utf-8"))
    return None if declared is None else declared[1] == "True"


def load(name: str) -> Model:
    """Import a model, or compose it; KeyError if there is none of that name."""
    if is_composed(name):
        try:
            return _composed(name)
        except ValueError as error:
            raise KeyError(str(error)) from error
    if name in _own:
        return _own[name].model
    path = model_files()[name]
    module = importlib.import_module(f"..{path.parent.name}.{name}", __package__)
    model = module.MODEL
    assert isinstance(model, Model)
    assert model.name == name
    return model


@cache
def _composed(name: str) -> Model:
    return composed(name, load)


def modules(name: str) -> tuple[Path, ...]:
    """List the files that make a model: its own, then those that compose it; KeyError if there is none."""
    base = _own[base_of(name)].file if is_own(name) else model_files()[base_of(name)]
    if not is_composed(name):
        return (base,)
    laws = sorted({ROOT / "effects" / f"{law}.py" for law in effects_of(name, load)})
    return (base, ROOT / "composed" / "names.py", *laws)


def source_files(*modules: Path) -> list[Path]:
    """
    List modules of this package with all that they import from the package, sorted by path.

    One that imports a folder by its name finds the modules in it at run time: all of them belong to it.
    """
    found: set[Path] = set()
    waiting = list(modules)
    while waiting:
        path = waiting.pop()
        if path in found:
            continue
        found |= {path, path.parent / "__init__.py"}
        waiting += _imported(path)
    return sorted(found)


def _holds_model(path: Path) -> bool:
    return "\nMODEL = " in path.read_text(encoding="utf-8")


@cache
def _imported(path: Path) -> tuple[Path, ...]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    found: list[Path] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level:
            folder = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            named = [folder / alias.name for alias in node.names]
            found += [c.with_suffix(".py") for c in (folder, *named) if c.with_suffix(".py").is_file()]
            found += [module for c in named if c.is_dir() for module in sorted(c.glob("*.py"))]
    return tuple(found)
