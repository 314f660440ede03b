"""XML of SSP, checked against what is understood: nothing that is not known passes silently."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from lxml import etree

from master.errors import ConfigError, expected, readable

from .names import PREFIXES, ssc

MOST_BYTES = 64 * 2**20  # of one XML file

_HARMLESS_NAMESPACES = ("http://www.w3.org/2001/XMLSchema-instance",)
_LANGUAGE = "{http://www.w3.org/XML/1998/namespace}lang"
_DOUBLE = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?INF|NaN")
_INTEGER = re.compile(r"[+-]?\d{1,20}")
_TRUTHS = {"true": True, "1": True, "false": False, "0": False}


def double(text: str) -> float:
    """Read an xs:double; ValueError says what is expected."""
    if _DOUBLE.fullmatch(text.strip()) is None:
        raise ValueError("expected a number")
    return float(text)


def integer(text: str, least: int = -(2**31), largest: int = 2**31 - 1) -> int:
    """Read an xs:int; ValueError says what is expected."""
    if _INTEGER.fullmatch(text.strip()) is None or not least <= int(text) <= largest:
        raise ValueError(f"expected an integer from {least} to {largest}")
    return int(text)


def boolean(text: str) -> bool:
    """Read an xs:boolean; ValueError says what is expected."""
    if text.strip() not in _TRUTHS:
        raise ValueError("expected true or false")
    return _TRUTHS[text.strip()]


def words(*allowed: str) -> Callable[[str], str]:
    """Make a reader of one of some words."""

    def read(text: str) -> str:
        if text not in allowed:
            raise ValueError(expected(text, allowed))
        return text

    return read


@dataclass(frozen=True)
class Rule:
    """
    What an element may hold.

    `attributes` gives the reader of each; `required` are those that must be there; `children` may be there,
    those in `many` more than once. `opaque` elements are not looked into.
    """

    attributes: Mapping[str, Callable[[str], object]] = field(default_factory=dict)
    required: frozenset[str] = frozenset()
    children: frozenset[str] = frozenset()
    many: frozenset[str] = frozenset()
    opaque: bool = False


@dataclass(frozen=True)
class Node:
    """An element of a checked file."""

    element: etree._Element
    file: str

    @property
    def tag(self) -> str:
        """Name without the namespace."""
        return str(etree.QName(self.element).localname)

    @property
    def where(self) -> str:
        """Archive, file, line and element."""
        return place(self.element, self.file)

    def get(self, name: str) -> str | None:
        """Text of an attribute."""
        text: str | None = self.element.get(name)
        return text

    def text(self, name: str) -> str:
        """Text of an attribute, empty if it is absent."""
        return self.element.get(name) or ""

    def child(self, tag: str) -> Node | None:
        """Find the child of a name."""
        found = self.element.find(tag)
        return None if found is None else Node(found, self.file)

    def children(self, path: str | None = None) -> Iterator[Node]:
        """Children, or the elements on a path; comments are left out."""
        found = self.element if path is None else self.element.iterfind(path)
        for one in found:
            if isinstance(one.tag, str):
                yield Node(one, self.file)


def place(element: etree._Element, file: str) -> str:
    """Name an element: file, line, what it is."""
    tag = _local(element.tag)
    a = element.attrib
    if tag == "Connection":
        ends = [
            ".".join(filter(None, (a.get(f"{end}Element"), a.get(f"{end}Connector"))))
            for end in ("start", "end")
        ]
        title = f" {ends[0]} - {ends[1]}"
    elif tag == "MappingEntry":
        title = f" {a.get('source')} - {a.get('target')}"
    else:
        title = f" {readable(a['name'])!r}" if "name" in a else ""
    return f"{file}:{element.sourceline}: {readable(tag)}{title}"


def read_xml(content: bytes, file: str, root: str, rules: Mapping[str, Rule]) -> Node:
    """
    Parse a file and check it.

    Args:
        content: Its bytes.
        file: What messages call it.
        root: Name of the root element.
        rules: What is understood of each element.

    Raises:
        ConfigError: With every element and attribute that is not understood.
    """
    if len(content) > MOST_BYTES:
        raise ConfigError([f"{file}: too large, got {len(content)} bytes, expected at most {MOST_BYTES}"])
    parser = etree.XMLParser(resolve_entities=False, no_network=True, remove_comments=True, remove_pis=True)
    try:
        element = etree.fromstring(content, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        raise ConfigError([f"{file}: not XML: {str(error).splitlines()[0]}"]) from None
    wrong = [entry for entry in parser.error_log if entry.level >= etree.ErrorLevels.ERROR]
    if wrong:  # of several faults the parser may let one pass, and drop what follows
        raise ConfigError([f"{file}: not XML: {wrong[0].message}, line {wrong[0].line}"])
    if element.getroottree().docinfo.doctype:
        raise ConfigError([f"{file}:1: a document type is not understood, expected plain XML"])
    if element.tag != root:
        raise ConfigError(
            [f"{file}:{element.sourceline}: not understood, got {short(element.tag)}, expected {short(root)}"]
        )
    check(element, file, rules)
    return Node(element, file)


def check(element: etree._Element, file: str, rules: Mapping[str, Rule]) -> None:
    """Check an element and all below it; ConfigError with every fault."""
    problems = list(_faults(element, file, rules))
    if problems:
        raise ConfigError(problems)


def _faults(element: etree._Element, file: str, rules: Mapping[str, Rule]) -> Iterator[str]:
    rule = rules[element.tag]
    where = place(element, file)
    yield from _attribute_faults(element, where, rule)
    if rule.opaque:
        return
    if any((text or "").strip() for text in (element.text, *(child.tail for child in element))):
        yield f"{where}: text is not understood, expected elements alone"
    seen: set[str] = set()
    for child in element:
        if not isinstance(child.tag, str):
            yield f"{file}:{child.sourceline}: an entity is not understood, expected plain XML"
        elif child.tag not in rule.children:
            known = sorted(short(tag) for tag in rule.children)
            wanted = expected(short(child.tag), known)
            yield f"{place(child, file)}: not understood in {short(element.tag)}, {wanted}"
        else:
            if child.tag in seen and child.tag not in rule.many:
                yield f"{place(child, file)}: twice in {short(element.tag)}, expected once"
            seen.add(child.tag)
            yield from _faults(child, file, rules)


def _attribute_faults(element: etree._Element, where: str, rule: Rule) -> Iterator[str]:
    for name, text in element.attrib.items():
        if name == _LANGUAGE or _namespace(name) in _HARMLESS_NAMESPACES:
            continue
        if name not in rule.attributes:
            yield f"{where}: {short(name)} is not understood, got {text!r}, {expected(name, rule.attributes)}"
            continue
        try:
            rule.attributes[name](text)
        except ValueError as error:
            yield f"{where}: {name}: not allowed, got {text!r}, {error}"
    for name in sorted(rule.required - set(element.attrib)):
        yield f"{where}: {name} is missing, expected a value"


def short(name: str) -> str:
    """Write a name with the usual prefix of its namespace."""
    namespace = _namespace(name)
    for prefix, uri in PREFIXES.items():
        if namespace == uri:
            return f"{prefix}:{readable(_local(name))}"
    return readable(name)


def _local(name: str) -> str:
    return name.rpartition("}")[2]


def _namespace(name: str) -> str:
    """Namespace of `{namespace}name`; none where a prefix is not declared, which lxml leaves in the name."""
    return name[1:].partition("}")[0] if name.startswith("{") else ""


ANNOTATIONS = ssc("Annotations")
