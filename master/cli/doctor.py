"""`dockloop doctor`: what this installation has, and what it lacks for which work."""

from __future__ import annotations

import importlib.metadata
import platform
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from fmu_sources.export import build
from fmu_sources.export.release import release_models
from master.fmi.platforms import FMI2_FOLDER, FMI3_FOLDER
from master.installation import (
    EXTRAS,
    IS_CHECKOUT,
    SHIPPED,
    cache_folder,
    can_be_written,
    install_command,
    shipped_configurations,
    wanted_cache_folder,
)

from .common import JSON, answers_errors, print_json, say

_COMPILERS = {"cc": "builds native FMUs for this machine; zig does where there is none"}
_NAME = re.compile(r"[\w.-]+")


@click.command()
@click.option("--clear-cache", is_flag=True, help="Remove all that was built and compiled here.")
@JSON
@answers_errors
def doctor(clear_cache: bool, as_json: bool) -> None:
    """Say what is installed, where caches are, and what each missing package is for."""
    if clear_cache:
        shutil.rmtree(cache_folder(), ignore_errors=True)
        cache_folder.cache_clear()
    found = _found()
    if as_json:
        print_json(found)
        return
    for line in _lines(found):
        say(line)


def _found() -> dict[str, Any]:
    wanted = wanted_cache_folder()
    is_kept = can_be_written(wanted)
    return {
        "dockloop": importlib.metadata.version("dockloop"),
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "binaries": [FMI2_FOLDER, FMI3_FOLDER],
        "installed_as": "checkout" if IS_CHECKOUT else "wheel",
        "folder": str(SHIPPED),
        "packages": {name: _version(name) for name in _requirements()},
        "compilers": {name: shutil.which(name) for name in _COMPILERS},
        "extras": {
            e.name: {"missing": e.missing, "purpose": e.purpose, "command": install_command(e.name)}
            for e in EXTRAS
        },
        "fmus": {
            name: "released" if _is_released(name) else "older than its sources" for name in release_models()
        },
        "configurations": len(shipped_configurations()),
        "cache": {"folder": str(wanted), "writable": is_kept, "bytes": _size(wanted) if is_kept else 0},
    }


def _requirements() -> Iterator[str]:
    """Names of the packages that dockloop needs always."""
    for requirement in importlib.metadata.requires("dockloop") or ():
        name = _NAME.match(requirement)
        if name is not None and "extra ==" not in requirement:
            yield name[0]


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _is_released(name: str) -> bool:
    return build.target(name).path.is_relative_to(SHIPPED)


def _size(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def _lines(found: dict[str, Any]) -> Iterator[str]:
    yield f"dockloop {found['dockloop']}, {found['installed_as']} in {found['folder']}"
    yield f"Python {found['python']} ({sys.executable}) on {found['platform']}"
    yield ""
    yield "packages"
    for name, version in found["packages"].items():
        yield f"  {name:<16}{version or 'missing'}"
    yield ""
    yield "extras"
    for name, extra in found["extras"].items():
        state = "installed" if not extra["missing"] else f"lacks {', '.join(extra['missing'])}"
        yield f"  {name:<16}{state:<28}{extra['purpose']}"
        if extra["missing"]:
            yield f"  {'':<16}{extra['command']}"
    yield ""
    yield "compilers"
    for name, path in found["compilers"].items():
        yield f"  {name:<16}{path or 'none':<28}{_COMPILERS[name]}"
    yield ""
    yield f"FMUs, for {' and '.join(found['binaries'])} here"
    for name, state in found["fmus"].items():
        yield f"  {name:<28}{state}"
    yield f"configurations: {found['configurations']}, listed by `dockloop examples`"
    yield ""
    cache = found["cache"]
    if cache["writable"]:
        yield f"cache: {cache['folder']}, {cache['bytes'] / 1e6:.1f} MB"
    else:
        yield f"cache: {cache['folder']} cannot be written; every run compiles for half a minute first"
        yield "       DOCKLOOP_CACHE names another folder"
