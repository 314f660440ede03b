"""
YAML as plain data, with the line of every key, so that a fault can be shown where it is.

Scalars keep their text (see `scalar`); what no description needs is refused (see `yaml_nodes`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

import yaml

from master.errors import ConfigError, Problem, readable, shown

from .scalar import Plain, Setting, boolean_of, is_impossible_date, number_of
from .yaml_nodes import TAG, Collection, Composer, Node, Scalar

MOST_BYTES = 32 * 2**20

Place = tuple[str | int, ...]


@dataclass(frozen=True)
class Document:
    """
    Data of a file and, for each path of keys into it, its line.

    What is wrong can be left out of the data (`without`); `written` keeps all that the file holds, and
    `renumbered` the numbers in the file of the entries of a list that is shorter now.
    """

    path: Path
    data: Any
    lines: Mapping[Place, int] = field(default_factory=dict)
    renumbered: Mapping[Place, tuple[int, ...]] = field(default_factory=dict)
    written: Any = None

    def names_in(self, section: str) -> list[str]:
        """Keys that the file holds in a section, those of wrong entries too."""
        whole = self.data if self.written is None else self.written
        entries = whole.get(section) if isinstance(whole, dict) else None
        return [str(key) for key in entries] if isinstance(entries, dict) else []

    def where(self, place: Place) -> str:
        """Name a place as `file:line: key.key[index]`; the nearest known parent gives the line."""
        written = self._as_written(place)
        known = written
        while known and known not in self.lines:
            known = known[:-1]
        return f"{self.path}:{self.lines.get(known, 1)}: {dotted(written)}"

    def name_of(self, place: Place) -> str:
        """Name a place as the file numbers it, without the line."""
        return dotted(self._as_written(place))

    def without(self, place: Place) -> Document:
        """Leave out what is at a place; later entries of a list keep their numbers in messages."""
        if not place:
            return replace(self, data=None)
        *way, last = place
        renumbered = dict(self.renumbered)
        if isinstance(last, int):
            home = tuple(way)
            numbers = renumbered.get(home) or tuple(range(len(self.at(home))))
            renumbered[home] = numbers[:last] + numbers[last + 1 :]
        return replace(self, data=_changed(self.data, place), renumbered=renumbered)

    def with_value(self, place: Place, value: Any) -> Document:
        """Put a value at a place."""
        return replace(self, data=_changed(self.data, place, value))

    def at(self, place: Place, default: Any = None) -> Any:
        """Value at a place; the default where there is none."""
        data: Any = self.data
        for key in place:
            if (isinstance(data, dict) and key in data) or (
                isinstance(data, list) and isinstance(key, int) and key < len(data)
            ):
                data = data[key]  # type: ignore[index]
            else:
                return default
        return data

    def _as_written(self, place: Place) -> Place:
        written: Place = ()
        for i, key in enumerate(place):
            numbers = self.renumbered.get(place[:i])
            inside = numbers is not None and isinstance(key, int) and key < len(numbers)
            written += (numbers[key] if inside else key,)  # type: ignore[index]
        return written


_LEFT_OUT = object()


def _changed(data: Any, place: Place, value: Any = _LEFT_OUT) -> Any:
    """Copy data with another value at a place, or without it."""
    first, *rest = place
    changed: Any = dict(data) if isinstance(data, dict) else list(data)
    if rest:
        changed[first] = _changed(data[first], tuple(rest), value)
    elif value is _LEFT_OUT:
        del changed[first]
    else:
        changed[first] = value
    return changed


def dotted(place: Place) -> str:
    """Write a path of keys as `connections[1].to`."""
    text = ""
    for key in place:
        if isinstance(key, int):
            text += f"[{key}]"
        else:
            text += f".{readable(key)}" if text else readable(key)
    return text or "file"


def read_yaml(path: Path) -> Document:
    """
    Read one YAML file.

    Raises:
        ConfigError: If the file is missing, is not YAML, has a key twice, or is refused (see above).
    """
    try:
        with path.open("rb") as file:
            content = file.read(MOST_BYTES + 1)
        text = content.decode("utf-8-sig")
    except OSError as error:
        problem = Problem("cannot be read", where=str(path), got=str(error.strerror), expected="a YAML file")
        raise ConfigError([problem]) from None
    except UnicodeDecodeError:
        raise ConfigError([Problem("not text", where=str(path), expected="a YAML file in UTF-8")]) from None
    if len(content) > MOST_BYTES:
        problem = Problem(
            "too large", where=str(path), got="more than 32 MB", expected=f"at most {MOST_BYTES} bytes"
        )
        raise ConfigError([problem])
    return parse_yaml(text, path)


def parse_yaml(text: str, path: Path) -> Document:
    """
    Read YAML from a text; `path` is its name in messages.

    Raises:
        ConfigError: As `read_yaml`.
    """
    try:
        root = Composer().compose(text)
    except yaml.YAMLError as error:
        raise ConfigError([_syntax_fault(path, text, error)]) from None
    except UnicodeEncodeError:
        raise ConfigError([Problem("not text", where=str(path), expected="no surrogates")]) from None
    constructor = _Constructor(path)
    data = None if root is None else constructor.data(root, ())
    if constructor.problems:
        raise ConfigError(constructor.problems)
    return Document(path, data, constructor.lines, written=data)


def write_yaml(data: Any) -> str:
    """Write data as YAML that `read_yaml` reads as the same data; plain texts stay without quotes."""
    text: str = yaml.dump(data, Dumper=_Dumper, sort_keys=False, default_flow_style=None, allow_unicode=True)
    return text


class _Dumper(yaml.SafeDumper):
    """SafeDumper that knows our kinds of text."""


def _plain(dumper: _Dumper, text: Plain) -> yaml.Node:
    tag = dumper.resolve(yaml.ScalarNode, str(text), (True, False))  # type: ignore[no-untyped-call]
    return dumper.represent_scalar(tag, str(text))


_Dumper.add_representer(Plain, _plain)
_Dumper.add_multi_representer(str, lambda dumper, text: dumper.represent_str(str(text)))


def parse_value(text: str) -> Setting | None:
    """
    Read a value, as in `--set fmu.parameter=VALUE`: text in quotes, plain text, a list of these, or nothing.

    Raises:
        ConfigError: If it is neither, or one that is refused; the problems have no place.
    """
    try:
        data = parse_yaml(text, Path("value")).data
    except ConfigError as error:
        problems = (Problem(p.what, got=p.got, expected=p.expected) for p in error.problems)
        raise ConfigError(problems) from None
    if data is not None and not _is_setting(data):
        expected = "a number, a text, or a list of them"
        raise ConfigError([Problem("not a value", got=shown(data), expected=expected)])
    return cast("Setting | None", data)


def _is_setting(data: Any) -> bool:
    return all(_is_setting(part) for part in data) if isinstance(data, list) else isinstance(data, str)


def _syntax_fault(path: Path, text: str, error: yaml.YAMLError) -> Problem:
    mark = getattr(error, "problem_mark", None)
    line = None if mark is None else mark.line + 1
    what = getattr(error, "problem", None) or str(error).splitlines()[0]
    if isinstance(error, yaml.reader.ReaderError):
        what = f"unacceptable character #x{ord(error.character):04x}" if _is_character(error) else what
        line = text.count("\n", 0, error.position) + 1
    place = f"{path}:" if line is None else f"{path}:{line}:"
    return Problem(f"not YAML: {what}", where=place.removesuffix(":"))


def _is_character(error: yaml.reader.ReaderError) -> bool:
    return isinstance(error.character, str) and len(error.character) == 1


class _Constructor:
    """Makes plain data of nodes and keeps lines and faults."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.lines: dict[Place, int] = {}
        self.problems: list[Problem] = []

    def data(self, node: Node, place: Place) -> Any:
        """Return the data of a node: a dict, a list, a text or None."""
        self.lines.setdefault(place, node.line)
        if isinstance(node, Scalar):
            return self._scalar(node, place)
        assert isinstance(node, Collection)
        if node.is_mapping:
            return self._mapping(node, place)
        return [self.data(item, (*place, i)) for i, item in enumerate(node.items)]

    def _scalar(self, node: Scalar, place: Place) -> str | None:
        kind = "" if node.tag is None else node.tag.removeprefix(TAG)
        if kind in ("", "null") and node.plain and not node.text:
            return None
        if kind in ("int", "float", "bool"):
            return self._tagged(node, kind, place)
        if not node.plain or kind == "str":
            return node.text
        if is_impossible_date(node.text):
            expected = "a date that there is, or quotes around a text"
            self._add(node.line, place, "no such date", node.text, expected)
        return Plain(node.text)

    def _tagged(self, node: Scalar, kind: str, place: Place) -> str:
        try:
            boolean_of(node.text) if kind == "bool" else number_of(node.text)
        except ValueError as error:
            self._add(node.line, place, str(error), shown(node.text), f"what the tag !!{kind} says")
        return Plain(node.text)

    def _mapping(self, node: Collection, place: Place) -> dict[str, Any]:
        found: dict[str, Any] = {}
        merged: dict[str, Any] = {}
        for key, value in zip(node.items[::2], node.items[1::2], strict=True):
            if not isinstance(key, Scalar):
                self._add(key.line, place, "a key that is a list or a mapping", "", "a name")
            elif key.plain and key.text == "<<":
                merged |= self._merged(value, place)
            elif key.text in found:
                first = self.lines[(*place, key.text)]
                self._add(key.line, (*place, key.text), f"key is given twice, first in line {first}", "", "")
            else:
                self.lines[(*place, key.text)] = key.line
                found[key.text] = self.data(value, (*place, key.text))
        return merged | found

    def _merged(self, node: Node, place: Place) -> dict[str, Any]:
        """Entries of the mappings that `<<` names; the first of a list comes first."""
        assert isinstance(node, Scalar | Collection)
        nodes = [node] if isinstance(node, Scalar) or node.is_mapping else node.items
        found: dict[str, Any] = {}
        for one in nodes:
            if isinstance(one, Collection) and one.is_mapping:
                found = self._mapping(one, place) | found
            else:
                self._add(one.line, (*place, "<<"), "not a mapping", "", "one, or a list of mappings")
        return found

    def _add(self, line: int, place: Place, what: str, got: str, expected: str) -> None:
        where = f"{self.path}:{line}: {dotted(place)}"
        self.problems.append(Problem(what, where=where, got=got, expected=expected))
