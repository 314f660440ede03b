"""
The bill of materials of a release of FMUs (CycloneDX 1.5): every file in every FMU, and what is not ours.

It says what the bytes of the FMUs say: no time, no machine, no version of a tool.
"""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

NAME = "bom.json"
OURS = "BSD-3-Clause"

_FMI_HEADERS = {
    "type": "library",
    "bom-ref": "fmi-headers",
    "name": "FMI headers (fmi2*.h, fmi3*.h)",
    "publisher": "Modelica Association Project FMI",
    "licenses": [{"license": {"id": "BSD-2-Clause"}}],
}
_COMPILER_RUNTIME = {
    "type": "library",
    "bom-ref": "compiler-rt",
    "name": "compiler-rt, as zig links it",
    "publisher": "LLVM and zig",
    "licenses": [{"expression": "MIT OR Apache-2.0 WITH LLVM-exception"}],
}
_WINDOWS_RUNTIME = {
    "type": "library",
    "bom-ref": "mingw-w64",
    "name": "mingw-w64 runtime, as zig links it into libraries for Windows",
    "publisher": "mingw-w64",
    "licenses": [{"license": {"id": "ZPL-2.1"}}],
}


def bill_of_materials(fmus: Mapping[str, bytes]) -> bytes:
    """Return the bill of FMUs, path in the release to content, as JSON."""
    components = [_fmu(path, content) for path, content in sorted(fmus.items())]
    foreign = [_COMPILER_RUNTIME, _FMI_HEADERS, _WINDOWS_RUNTIME]
    used = [one["bom-ref"] for one in foreign]
    bill = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": {"type": "application", "bom-ref": "release", "name": "dockloop FMUs"}},
        "components": [*components, *foreign],
        "dependencies": [
            {"ref": "release", "dependsOn": [one["bom-ref"] for one in components]},
            *({"ref": one["bom-ref"], "dependsOn": used} for one in components),
        ],
    }
    return json.dumps(bill, indent=1, sort_keys=True).encode() + b"\n"


def _fmu(path: str, content: bytes) -> dict[str, Any]:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        inside = {name: archive.read(name) for name in sorted(archive.namelist())}
    return {
        "type": "library",
        "bom-ref": path,
        "name": path,
        "hashes": _hashes(content),
        "licenses": [{"license": {"id": OURS}}],
        "components": [_file(name, data) for name, data in inside.items()],
    }


def _file(name: str, content: bytes) -> dict[str, Any]:
    own: dict[str, Any] = {"type": "file", "name": name, "hashes": _hashes(content)}
    if _is_header_of_fmi(name):
        own["licenses"] = _FMI_HEADERS["licenses"]
    return own


def _is_header_of_fmi(name: str) -> bool:
    path = PurePosixPath(name)
    return path.parent.name == "sources" and path.suffix == ".h" and path.name.startswith(("fmi2", "fmi3"))


def _hashes(content: bytes) -> list[dict[str, str]]:
    return [{"alg": "SHA-256", "content": hashlib.sha256(content).hexdigest()}]
