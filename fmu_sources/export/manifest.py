"""
What a release records of each model: the sources it was built from, the digest of its content, its GUID.

A GUID names a content: it stays as long as what the sources generate stays, however the sources are moved or
rewritten. The recorded sources tell without generating anything whether an FMU of the release is current.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

NAME = "MANIFEST.json"


@dataclass(frozen=True)
class Entry:
    """One model of a release: digests of its sources and of what they generate, and the GUID of both FMUs."""

    sources: str
    content: str
    token: str


def read_manifest(folder: Path) -> dict[str, Entry]:
    """Read the models of a release; none where there is no release."""
    path = folder / NAME
    if not path.is_file():
        return {}
    models = json.loads(path.read_text(encoding="utf-8")).get("models", {})
    return {name: Entry(**entry) for name, entry in models.items()}


def manifest(files: Mapping[Path, bytes], entries: Mapping[str, Entry], folder: Path) -> bytes:
    """List the files of a release with their SHA-256, and its models."""
    sums = {p.relative_to(folder).as_posix(): hashlib.sha256(c).hexdigest() for p, c in sorted(files.items())}
    models = {name: asdict(entry) for name, entry in sorted(entries.items())}
    return json.dumps({"sha256": sums, "models": models}, indent=2).encode() + b"\n"
