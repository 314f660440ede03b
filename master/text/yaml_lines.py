"""
YAML as plain data, with the line of every key, so that a fault can be shown where it is.

Scalars keep their text (see `scalar`). What a system or a case does not need is refused: tags other
than those of texts, numbers, mappings and lists; aliases within themselves or that multiply beyond
`MOST_REPEATED` values; more than `MOST_LEVELS` levels or `MOST_BYTES` bytes; NUL and surrogates.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import yaml

from master.errors import ConfigError, Problem, shown

from .scalar import Plain, boolean_of, number_of

MOST_BYTES = 32 * 2**20
MOST_LEVELS = 60
MOST_REPEATED = 100_000

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
        data = self.data
        for key in place:
            if (isinstance(data, dict) and key in data) or (
                isinstance(data, list) and isinstance(key, int) and key < len(data)
            ):
                data = data[key]
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
        part = f"[{key}]" if isinstance(key, int) else str(key) if not text else f".{key}"
        text += part
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
        root = _Composer(path).compose(text)
    except yaml.YAMLError as error:
        raise ConfigError([_syntax_fault(path, text, error)]) from None
    except UnicodeEncodeError:
        raise ConfigError([Problem("not text", where=str(path), expected="no surrogates")]) from None
    constructor = _Constructor(path)
    data = None if root is None else constructor.data(root, ())
    if constructor.problems:
        raise ConfigError(constructor.problems)
    return Document(path, data, constructor.lines, written=data)


def parse_value(text: str) -> str | None:
    """
    Read a single scalar, as in `--set fmu.parameter=VALUE`: text in quotes, plain text, or nothing.

    Raises:
        ConfigError: If it is no scalar.
    """
    data = parse_yaml(text, Path("value")).data
    if data is not None and not isinstance(data, str):
        raise ConfigError([Problem("not a value", got=shown(data), expected="a number or a text")])
    return data


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


@dataclass
class _Node:
    """A scalar, a sequence or a mapping with its line, and how many values it has with all aliases."""

    line: int
    size: int = 1
    anchor: str | None = None


@dataclass
class _Scalar(_Node):
    text: str = ""
    plain: bool = True
    tag: str | None = None


@dataclass
class _Collection(_Node):
    is_mapping: bool = False
    items: list[_Node] = field(default_factory=list)


_TAG = "tag:yaml.org,2002:"
_SCALAR_TAGS = {"!", *(_TAG + name for name in ("str", "int", "float", "bool", "null"))}
_MAPPING_TAGS = {"!", _TAG + "map"}
_SEQUENCE_TAGS = {"!", _TAG + "seq"}


class _Refused(yaml.MarkedYAMLError):
    """YAML that is valid, but more than a description of a system needs."""

    def __init__(self, what: str, event: Any) -> None:
        super().__init__(problem=what, problem_mark=event.start_mark)


class _Composer:
    """Makes nodes of the parser's events, without recursion."""

    def __init__(self, path: Path) -> None:
        self.anchors: dict[str, _Node] = {}
        self.open: list[_Collection] = []
        self.root: _Node | None = None
        self.documents = 0
        self.n_written = 0

    def compose(self, text: str) -> _Node | None:
        """Return the root of the one document in a text; None if it is empty."""
        for event in _events(text):
            if isinstance(event, yaml.DocumentStartEvent):
                self.documents += 1
                if self.documents > 1:
                    raise _Refused("a second document, expected one", event)
            elif isinstance(event, yaml.AliasEvent):
                self._add(self._alias(event), event)
            elif isinstance(event, yaml.ScalarEvent):
                self._add(self._scalar(event), event)
            elif isinstance(event, yaml.CollectionStartEvent):
                self._begin(event)
            elif isinstance(event, yaml.CollectionEndEvent):
                self._end(event)
        return self.root

    def _alias(self, event: yaml.AliasEvent) -> _Node:
        if event.anchor not in self.anchors:
            raise _Refused(f"no anchor of this name, got *{event.anchor}", event)
        node = self.anchors[event.anchor]
        if any(node is one for one in self.open):
            raise _Refused(f"an alias within what it repeats, got *{event.anchor}", event)
        return node

    def _scalar(self, event: Any) -> _Node:
        self._check_tag(event, _SCALAR_TAGS)
        if any(c == "\0" or "\ud800" <= c <= "\udfff" for c in event.value):
            raise _Refused("NUL or a surrogate, expected characters of Unicode", event)
        tag = None if event.tag in (None, "!") else event.tag
        plain = not event.style and event.tag != "!"
        return self._named(_Scalar(event.start_mark.line + 1, text=event.value, plain=plain, tag=tag), event)

    def _begin(self, event: Any) -> None:
        is_mapping = isinstance(event, yaml.MappingStartEvent)
        self._check_tag(event, _MAPPING_TAGS if is_mapping else _SEQUENCE_TAGS)
        if len(self.open) >= MOST_LEVELS:
            raise _Refused(f"more than {MOST_LEVELS} levels", event)
        node = _Collection(event.start_mark.line + 1, is_mapping=is_mapping)
        self.open.append(node)
        self._named(node, event)

    def _end(self, event: yaml.CollectionEndEvent) -> None:
        node = self.open.pop()
        node.size += sum(item.size for item in node.items)
        if node.size > self.n_written + MOST_REPEATED:
            raise _Refused(f"aliases repeat more than {MOST_REPEATED} values", event)
        self._add(node, event)

    def _named(self, node: _Node, event: yaml.NodeEvent) -> _Node:
        self.n_written += 1
        if event.anchor is not None:
            self.anchors[event.anchor] = node
        return node

    def _check_tag(self, event: Any, known: set[str]) -> None:
        if event.tag is not None and event.tag not in known:
            raise _Refused(f"tag not known, got {event.tag.replace(_TAG, '!!')!r}, expected none", event)

    def _add(self, node: _Node, event: yaml.Event) -> None:
        if self.open:
            self.open[-1].items.append(node)
        else:
            self.root = node


def _events(text: str) -> Iterator[yaml.Event]:
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml's parser is some ten times as fast
    return yaml.parse(text, Loader=loader)


class _Constructor:
    """Makes plain data of nodes and keeps lines and faults."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.lines: dict[Place, int] = {}
        self.problems: list[Problem] = []

    def data(self, node: _Node, place: Place) -> Any:
        """Return the data of a node: a dict, a list, a text or None."""
        self.lines.setdefault(place, node.line)
        if isinstance(node, _Scalar):
            return self._scalar(node, place)
        assert isinstance(node, _Collection)
        if node.is_mapping:
            return self._mapping(node, place)
        return [self.data(item, (*place, i)) for i, item in enumerate(node.items)]

    def _scalar(self, node: _Scalar, place: Place) -> str | None:
        kind = "" if node.tag is None else node.tag.removeprefix(_TAG)
        if kind in ("", "null") and node.plain and not node.text:
            return None
        if kind in ("int", "float", "bool"):
            return self._tagged(node, kind, place)
        return Plain(node.text) if node.plain and kind != "str" else node.text

    def _tagged(self, node: _Scalar, kind: str, place: Place) -> str:
        try:
            boolean_of(node.text) if kind == "bool" else number_of(node.text)
        except ValueError as error:
            self._add(node.line, place, str(error), shown(node.text), f"what the tag !!{kind} says")
        return Plain(node.text)

    def _mapping(self, node: _Collection, place: Place) -> dict[str, Any]:
        found: dict[str, Any] = {}
        merged: dict[str, Any] = {}
        for key, value in zip(node.items[::2], node.items[1::2], strict=True):
            if not isinstance(key, _Scalar):
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

    def _merged(self, node: _Node, place: Place) -> dict[str, Any]:
        """Entries of the mappings that `<<` names; the first of a list comes first."""
        assert isinstance(node, _Scalar | _Collection)
        nodes = [node] if isinstance(node, _Scalar) or node.is_mapping else node.items
        found: dict[str, Any] = {}
        for one in nodes:
            if isinstance(one, _Collection) and one.is_mapping:
                found = self._mapping(one, place) | found
            else:
                self._add(one.line, (*place, "<<"), "not a mapping", "", "one, or a list of mappings")
        return found

    def _add(self, line: int, place: Place, what: str, got: str, expected: str) -> None:
        where = f"{self.path}:{line}: {dotted(place)}"
        self.problems.append(Problem(what, where=where, got=got, expected=expected))
