"""
YAML as nodes with lines, without recursion and within limits.

What a system or a case does not need is refused: tags other than those of texts, numbers, mappings and
lists; aliases within themselves, or that repeat more than `MOST_REPEATED` values; more than `MOST_LEVELS`
levels; a second document; NUL and surrogates.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import yaml

MOST_LEVELS = 60
MOST_REPEATED = 100_000


@dataclass
class Node:
    """A scalar, a sequence or a mapping with its line, and how many values it has with all aliases."""

    line: int
    size: int = 1
    anchor: str | None = None


@dataclass
class Scalar(Node):
    """A scalar; `plain` where it is not in quotes."""

    text: str = ""
    plain: bool = True
    tag: str | None = None


@dataclass
class Collection(Node):
    """A sequence, or a mapping with keys and values in turn."""

    is_mapping: bool = False
    items: list[Node] = field(default_factory=list)


TAG = "tag:yaml.org,2002:"
_SCALARTAGS = {"!", *(TAG + name for name in ("str", "int", "float", "bool", "null"))}
_MAPPINGTAGS = {"!", TAG + "map"}
_SEQUENCETAGS = {"!", TAG + "seq"}


class Refused(yaml.MarkedYAMLError):
    """YAML that is valid, but more than a description of a system needs."""

    def __init__(self, what: str, event: Any) -> None:
        super().__init__(problem=what, problem_mark=event.start_mark)


class Composer:
    """Makes nodes of the parser's events, without recursion."""

    def __init__(self) -> None:
        self.anchors: dict[str, Node] = {}
        self.open: list[Collection] = []
        self.root: Node | None = None
        self.documents = 0
        self.n_written = 0

    def compose(self, text: str) -> Node | None:
        """Return the root of the one document in a text; None if it is empty."""
        for event in _events(text):
            if isinstance(event, yaml.DocumentStartEvent):
                self.documents += 1
                if self.documents > 1:
                    raise Refused("a second document, expected one", event)
            elif isinstance(event, yaml.AliasEvent):
                self._add(self._alias(event), event)
            elif isinstance(event, yaml.ScalarEvent):
                self._add(self._scalar(event), event)
            elif isinstance(event, yaml.CollectionStartEvent):
                self._begin(event)
            elif isinstance(event, yaml.CollectionEndEvent):
                self._end(event)
        return self.root

    def _alias(self, event: yaml.AliasEvent) -> Node:
        if event.anchor not in self.anchors:
            raise Refused(f"no anchor of this name, got *{event.anchor}", event)
        node = self.anchors[event.anchor]
        if any(node is one for one in self.open):
            raise Refused(f"an alias within what it repeats, got *{event.anchor}", event)
        return node

    def _scalar(self, event: Any) -> Node:
        self._check_tag(event, _SCALARTAGS)
        if any(c == "\0" or "\ud800" <= c <= "\udfff" for c in event.value):
            raise Refused("NUL or a surrogate, expected characters of Unicode", event)
        tag = None if event.tag in (None, "!") else event.tag
        plain = not event.style and event.tag != "!"
        return self._named(Scalar(event.start_mark.line + 1, text=event.value, plain=plain, tag=tag), event)

    def _begin(self, event: Any) -> None:
        is_mapping = isinstance(event, yaml.MappingStartEvent)
        self._check_tag(event, _MAPPINGTAGS if is_mapping else _SEQUENCETAGS)
        if len(self.open) >= MOST_LEVELS:
            raise Refused(f"more than {MOST_LEVELS} levels", event)
        node = Collection(event.start_mark.line + 1, is_mapping=is_mapping)
        self.open.append(node)
        self._named(node, event)

    def _end(self, event: yaml.CollectionEndEvent) -> None:
        node = self.open.pop()
        node.size += sum(item.size for item in node.items)
        if node.size > self.n_written + MOST_REPEATED:
            raise Refused(f"aliases repeat more than {MOST_REPEATED} values", event)
        self._add(node, event)

    def _named(self, node: Node, event: yaml.NodeEvent) -> Node:
        self.n_written += 1
        if event.anchor is not None:
            self.anchors[event.anchor] = node
        return node

    def _check_tag(self, event: Any, known: set[str]) -> None:
        if event.tag is not None and event.tag not in known:
            raise Refused(f"tag not known, got {event.tag.replace(TAG, '!!')!r}, expected none", event)

    def _add(self, node: Node, event: yaml.Event) -> None:
        if self.open:
            self.open[-1].items.append(node)
        else:
            self.root = node


def _events(text: str) -> Iterator[yaml.Event]:
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml's parser is some ten times as fast
    return yaml.parse(text, Loader=loader)
