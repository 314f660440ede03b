"""
What the package is made of and depends on.

    python -m tests.reliability.packages wheel            build it twice; the bytes are the same
    python -m tests.reliability.packages bill FILE        write a bill of materials (CycloneDX 1.5, JSON)
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

PROJECT = Path(__file__).parents[2]
EPOCH = "1577836800"  # 2020-01-01, of files whose time would be that of the checkout
_REQUIREMENT = re.compile(r"(?P<name>[A-Za-z0-9._-]+)(?:\[[^]]*\])?(?P<bounds>[^;]*)(?P<marker>;.*)?")


def requirements(extra: str | None = None) -> list[tuple[str, str]]:
    """Return name and bounds of each dependency of a run, or of an extra."""
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    found = []
    for line in project["dependencies"] if extra is None else project["optional-dependencies"][extra]:
        match = _REQUIREMENT.fullmatch(line)
        assert match is not None, line
        found.append((match["name"], match["bounds"]))
    return found


def oldest(bounded: list[tuple[str, str]]) -> list[str]:
    """Return the lower bound of each dependency, with the repairs that it got, as a constraint of pip."""
    found = []
    for name, bounds in bounded:
        least = re.search(r">=([0-9.]+)", bounds)
        assert least is not None, f"{name} has no lower bound"
        parts = least[1].split(".")
        lowest = ".".join([*parts, "0", "0"][:3])
        found.append(f"{name}=={lowest}" if len(parts) > 2 else f"{name}~={lowest}")
    return found


def wheel(folder: Path) -> Path:
    """Build the wheel."""
    environment = os.environ | {"SOURCE_DATE_EPOCH": EPOCH}
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(command, cwd=PROJECT, env=environment, check=True, capture_output=True)
    [found] = folder.glob("*.whl")
    return found


def digest(path: Path) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def needed(name: str, known: dict[str, Distribution]) -> Iterator[Distribution]:
    """Yield an installed distribution and all that it needs, each once; extras are left out."""
    key = re.sub(r"[-_.]+", "-", name).lower()
    if key in known:
        return
    try:
        known[key] = found = distribution(name)
    except PackageNotFoundError:  # for another system or version of Python
        return
    yield found
    for line in found.requires or ():
        match = _REQUIREMENT.fullmatch(line)
        if match is not None and "extra ==" not in (match["marker"] or ""):
            yield from needed(match["name"], known)


def bill_of_materials() -> dict[str, Any]:
    """Return what is installed for a run: names, versions, licences."""
    known: dict[str, Distribution] = {}
    components = [
        {
            "type": "library",
            "name": one.metadata["Name"],
            "version": one.version,
            "purl": f"pkg:pypi/{one.metadata['Name'].lower()}@{one.version}",
            "licenses": [{"license": {"name": _licence(one)}}],
        }
        for name, _ in requirements()
        for one in needed(name, known)
    ]
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": {"type": "application", "name": "dockloop", "version": _own_version()}},
        "components": sorted(components, key=lambda one: str(one["name"]).lower()),
    }


def _own_version() -> str:
    return str(tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]["version"])


def _licence(one: Distribution) -> str:
    expression = one.metadata.get("License-Expression")
    classifiers = [c for c in one.metadata.get_all("Classifier") or () if c.startswith("License ::")]
    named = expression or (classifiers[0].rpartition(":: ")[2] if classifiers else None)
    return named or (one.metadata.get("License") or "not stated").splitlines()[0][:80]


if __name__ == "__main__":
    what = sys.argv[1] if sys.argv[1:] else ""
    if what == "wheel":
        with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
            digests = {digest(wheel(Path(one))), digest(wheel(Path(two)))}
        sys.stdout.write(f"{' '.join(digests)}\n")
        sys.exit(len(digests) - 1)
    if what == "bill" and sys.argv[2:]:
        Path(sys.argv[2]).write_text(json.dumps(bill_of_materials(), indent=2) + "\n", encoding="utf-8")
    else:
        sys.exit(__doc__)
