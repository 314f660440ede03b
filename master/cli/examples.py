"""`dockloop examples`: the configurations that are shipped, listed or copied."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from pathlib import Path

import click

from master.errors import ConfigError, Problem
from master.installation import CONFIG_FOLDER, shipped_configuration, shipped_configurations
from master.recording.folder import reason
from master.text.yaml_lines import read_yaml

from .common import JSON, answers_errors, say

_SCHEMA = re.compile(r"^# yaml-language-server: \$schema=(\S+)", re.MULTILINE)


@click.command()
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option(
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path(),
    metavar="DIR",
    help="Folder to copy into; the present one by default.",
)
@JSON
@answers_errors
def examples(names: tuple[str, ...], output: Path, as_json: bool) -> None:
    """List the shipped configurations, or copy those of NAMEs to change them."""
    if not names:
        _list(as_json)
        return
    sources = dict.fromkeys(path for name in names for path in _files_of(shipped_configuration(name)))
    copied = _copy(sources, output)
    if as_json:
        say(json.dumps({"files": [str(path) for path in copied]}, indent=2))
        return
    for path in copied:
        say(str(path))


def _list(as_json: bool) -> None:
    found = {name: _described(path) for name, path in shipped_configurations().items()}
    if as_json:
        say(json.dumps(found, indent=2))
        return
    wide = max(map(len, found), default=0) + 2
    for name, description in found.items():
        say(f"{name:<{wide}}{description}".rstrip())


def _described(path: Path) -> str:
    described = read_yaml(path).data.get("description", "")
    return " ".join(str(described).split())


def _files_of(source: Path) -> list[Path]:
    """List a configuration and the files that it names, of those that are shipped."""
    data = read_yaml(source).data
    recordings = data.get("recordings")
    entries = recordings.values() if isinstance(recordings, dict) else ()
    named = [data.get("system"), *(entry.get("file") for entry in entries if isinstance(entry, dict))]
    named += _SCHEMA.findall(source.read_text(encoding="utf-8"))
    found = [(source.parent / name).resolve() for name in named if isinstance(name, str)]
    return [source, *(path for path in found if path.is_file() and path.is_relative_to(CONFIG_FOLDER))]


def _copy(sources: Iterable[Path], folder: Path) -> list[Path]:
    """Copy files into a folder as they lie in that of the configurations; nothing is replaced."""
    targets = {folder / source.relative_to(CONFIG_FOLDER): source for source in sources}
    taken = [path for path in targets if path.exists()]
    if taken:
        raise ConfigError(
            Problem("is there already", where=str(path), expected="no such file, or another --output")
            for path in taken
        )
    for path, source in targets.items():
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(source.read_bytes())
        except OSError as error:
            raise ConfigError([Problem(f"cannot be written: {reason(error)}", where=str(path))]) from None
    return list(targets)
