"""Models by name: `<room>/<name>.py` holds the model `name` as `MODEL`."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path

from .model import Model

ROOT = Path(__file__).parent
ROOMS = (
    "spacecraft",
    "motion_simulator",
    "docking_contact",
    "force_sensor",
    "compensator",
    "real_docking",
    "rigs",
)


def model_files() -> dict[str, Path]:
    """Map each model's name to its file, in the order of the rooms."""
    files = (path for room in ROOMS for path in sorted((ROOT / room).glob("*.py")))
    return {path.stem: path for path in files if _holds_model(path)}


def load(name: str) -> Model:
    """Import a model; KeyError if there is none of that name."""
    path = model_files()[name]
    module = importlib.import_module(f".{path.parent.name}.{name}", __package__)
    model = module.MODEL
    assert isinstance(model, Model)
    assert model.name == name
    return model


def source_files(module: Path) -> list[Path]:
    """List a module of this package with all that it imports from the package, sorted by path."""
    found: set[Path] = set()
    waiting = [module]
    while waiting:
        path = waiting.pop()
        if path in found:
            continue
        found |= {path, path.parent / "__init__.py"}
        waiting += _imported(path)
    return sorted(found)


def _holds_model(path: Path) -> bool:
    return "\nMODEL = " in path.read_text(encoding="utf-8")


def _imported(path: Path) -> list[Path]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level:
            folder = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            candidates = [folder, *(folder / alias.name for alias in node.names)]
            found += [c.with_suffix(".py") for c in candidates if c.with_suffix(".py").is_file()]
    return found
