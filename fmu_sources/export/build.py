"""FMUs from sources: what is missing or stale is built, the rest is left as it is."""

from __future__ import annotations

import xml.etree.ElementTree as ET
import zipfile
from dataclasses import dataclass
from pathlib import Path

from ..registry import ROOT, load, model_files
from .python_flavour import build_python, python_sources, python_token

FMU_FOLDER = ROOT.parent / "fmus"


@dataclass(frozen=True)
class Target:
    """One FMU to be: the model, its flavour and where the file stands."""

    model: str
    flavour: str
    path: Path
    token: str

    def is_current(self) -> bool:
        """Whether the file is there and was built from the present sources."""
        return self.path.is_file() and token_of(self.path) == self.token


def token_of(path: Path) -> str:
    """Read the GUID of an FMU; empty if the file is not one."""
    try:
        with zipfile.ZipFile(path) as archive:
            root = ET.fromstring(archive.read("modelDescription.xml"))
    except (zipfile.BadZipFile, KeyError, ET.ParseError):
        return ""
    return root.get("guid") or root.get("instantiationToken") or ""


def target(name: str, flavour: str = "python", folder: Path = FMU_FOLDER) -> Target:
    """Name the FMU of a model; KeyError if there is no such model or flavour."""
    file = model_files()[name]
    path = {"python": folder / "python" / f"{name}.fmu"}[flavour]
    return Target(name, flavour, path, python_token(load(name), python_sources(file)))


def build(wanted: Target) -> Path:
    """Build the FMU and put it in its place in one move."""
    content = build_python(load(wanted.model), model_files()[wanted.model])
    wanted.path.parent.mkdir(parents=True, exist_ok=True)
    partial = wanted.path.with_suffix(".partial")
    partial.write_bytes(content)
    partial.replace(wanted.path)
    return wanted.path
