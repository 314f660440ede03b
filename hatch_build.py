"""The wheel's bill of materials (CycloneDX 1.5): every file that is shipped, and what a run is built on."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

NAME = "dockloop.cdx.json"
PLOTTER = {"name": "uPlot", "file": "uPlot.iife.min.js", "licence": "MIT"}


class BillOfMaterials(BuildHookInterface[Any]):
    """
    Writes the bill for `.dist-info/sboms` (PEP 770).

    It holds neither a time nor what this machine has installed: the same sources have the same bill. What
    an installation has of the dependencies, `python -m tests.reliability.packages bill` says.
    """

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable":
            return
        self._folder = tempfile.mkdtemp(prefix="dockloop-")
        files = {
            one.distribution_path: Path(one.path)
            for one in self.build_config.builder.recurse_included_files()
        }
        core = self.metadata.core
        bill = bill_of_materials(core.name, core.version or self.metadata.version, core.dependencies, files)
        path = Path(self._folder) / NAME
        path.write_text(json.dumps(bill, indent=1, sort_keys=True) + "\n", encoding="utf-8")
        build_data["sbom_files"].append(str(path))

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        if version != "editable":
            shutil.rmtree(self._folder)


def bill_of_materials(
    name: str, version: str, requirements: list[str], files: dict[str, Path]
) -> dict[str, Any]:
    """Return the bill of a package: its files with their SHA-256, its requirements with their bounds."""
    own = f"pkg:pypi/{name}@{version}"
    shipped = [_shipped(path, source) for path, source in sorted(files.items())]
    required = [_required(requirement) for requirement in sorted(requirements)]
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {
            "component": {
                "type": "application",
                "bom-ref": own,
                "name": name,
                "version": version,
                "purl": own,
                "licenses": [{"license": {"id": "BSD-3-Clause"}}],
            }
        },
        "components": [*required, *shipped],
        "dependencies": [{"ref": own, "dependsOn": [one["bom-ref"] for one in required]}],
    }


def _shipped(path: str, source: Path) -> dict[str, Any]:
    digest = hashlib.sha256(source.read_bytes()).hexdigest()
    component = {
        "type": "file",
        "bom-ref": path,
        "name": path,
        "hashes": [{"alg": "SHA-256", "content": digest}],
    }
    if source.name == PLOTTER["file"]:
        component |= {"description": PLOTTER["name"], "licenses": [{"license": {"id": PLOTTER["licence"]}}]}
    return component


def _required(requirement: str) -> dict[str, Any]:
    match = re.match(r"[A-Za-z0-9._-]+", requirement)
    assert match is not None, requirement
    purl = f"pkg:pypi/{re.sub(r'[-_.]+', '-', match[0]).lower()}"
    bounds = {"name": "dockloop:requirement", "value": requirement}
    return {"type": "library", "bom-ref": purl, "name": match[0], "purl": purl, "properties": [bounds]}
