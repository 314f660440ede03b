"""YAML as plain data, with the line of every key, so that a fault can be shown where it stands."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from master.errors import ConfigError

Place = tuple[str | int, ...]


@dataclass(frozen=True)
class Document:
    """Parsed data and, for each path of keys into it, its line."""

    path: Path
    data: Any
    lines: dict[Place, int] = field(default_factory=dict)

    def where(self, place: Place) -> str:
        """Name a place as `file:line: key.key[index]`; the nearest known parent gives the line."""
        known = place
        while known and known not in self.lines:
            known = known[:-1]
        return f"{self.path}:{self.lines.get(known, 1)}: {dotted(place)}"


def dotted(place: Place) -> str:
    """Write a path of keys as `connections[1].to`."""
    text = ""
    for key in place:
        text += f"[{key}]" if isinstance(key, int) else f".{key}" if text else str(key)
    return text or "file"


def read_yaml(path: Path) -> Document:
    """
    Read one YAML file.

    Raises:
        ConfigError: If the file is missing, is not YAML, or has a key twice.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ConfigError([f"{path}: cannot be read, got {error.strerror}, expected a YAML file"]) from None
    except UnicodeDecodeError:
        raise ConfigError([f"{path}: not text, expected a YAML file in UTF-8"]) from None
    try:
        root = yaml.compose(text, Loader=_Loader)
        data = yaml.load(text, Loader=_Loader)
    except yaml.YAMLError as error:
        raise ConfigError([_syntax_fault(path, error)]) from None
    document = Document(path, data)
    repeated: list[str] = []
    if root is not None:
        _walk(root, (), document, repeated)
    if repeated:
        raise ConfigError(repeated)
    return document


class _Loader(yaml.SafeLoader):
    """SafeLoader that reads 1e-3 as a number and on, off, yes, no as words, as YAML 1.2 does."""


_BOOLEAN = "tag:yaml.org,2002:bool"
_Loader.yaml_implicit_resolvers = {
    first: [r for r in resolvers if r[0] != _BOOLEAN]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_Loader.add_implicit_resolver(_BOOLEAN, re.compile(r"(?:true|True|TRUE|false|False|FALSE)$"), list("tTfF"))
_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)[eE][-+]?\d+$"),
    list("-+.0123456789"),
)


def parse_value(text: str) -> Any:
    """Read a single YAML value, as in `--set fmu.parameter=VALUE`."""
    return yaml.load(text, Loader=_Loader)


def _syntax_fault(path: Path, error: yaml.YAMLError) -> str:
    mark = getattr(error, "problem_mark", None)
    line = "" if mark is None else f"{mark.line + 1}:"
    problem = getattr(error, "problem", None) or str(error).splitlines()[0]
    return f"{path}:{line} not YAML: {problem}"


def _walk(node: yaml.Node, place: Place, document: Document, repeated: list[str]) -> None:
    document.lines.setdefault(place, node.start_mark.line + 1)
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            inner = (*place, str(key.value))
            if inner in document.lines:
                first = document.lines[inner]
                line = key.start_mark.line + 1
                repeated.append(
                    f"{document.path}:{line}: {dotted(inner)}: key stands twice, first in line {first}"
                )
                continue
            document.lines[inner] = key.start_mark.line + 1
            _walk(value, inner, document, repeated)
    elif isinstance(node, yaml.SequenceNode):
        for i, value in enumerate(node.value):
            _walk(value, (*place, i), document, repeated)
