"""Changes of valid inputs, drawn from a generator: of texts, of bytes, and of trees that stay well formed."""

from __future__ import annotations

import random
from copy import deepcopy

from lxml import etree

Tree = dict[str, "Tree"] | list["Tree"] | str | int | float | bool | None

WORDS = (
    *("null", "~", "true", "1e999", "-0", "nan", ".inf", "0x10", "[]", "{}", "''", '"', "'", "&a", "*a"),
    *("!!int", "!!python/object:os.system x", "? a", ": ", "- ", "\t", "\u0000", "\u202e", "é" * 50),
    *("9" * 400, "a" * 5000, "mass", "mass.f", "sensor", "events", "-1", "0", "1e-300", "9" * 20, "../.."),
    *("file:///etc", "2026-11-30", "1:30", "1_000", "=cmd()", "\x1b[31m", "<b>", "%s%n", "{{7*7}}"),
    *("${HOME}", "|", ">", "#", "", " ", "٣", "１", "1e308", "-1e308", "5e-324", "2147483648", "1,5"),
)
VALUES: tuple[Tree, ...] = (
    *(None, True, False, 0, -1, 1, 2**31, 2**63, 2**64, 10**400, -(10**25), 0.5, -0.0, 1e-300, 1e300),
    *(float("inf"), float("nan"), "", " ", "a" * 5000, "mass.f", "mass.s_des", "sensor.sigma", "\x1b[31m"),
    *(
        "1e3",
        "nan",
        "é" * 50,
        "../../x",
        [],
        {},
        [[]],
        [1, "a", None],
        {"a": 1},
        {"": None},
        [{}],
        {"mass": []},
    ),
)


def mutated(text: str, draw: random.Random) -> str:
    """Change a text in one to four places."""
    for _ in range(draw.randint(1, 4)):
        i = draw.randrange(len(text) + 1)
        j = min(len(text), i + draw.choice((0, 1, 2, 5, 20)))
        kind = draw.randrange(5)
        if kind == 0:
            text = text[:i] + draw.choice(WORDS) + text[j:]
        elif kind == 1:
            text = text[:i] + text[j:]
        elif kind == 2:
            text = text[:j] + text[i:]
        elif kind == 3:
            tokens = [*text.replace("{", " { ").replace(":", ": ").split(" ")]
            tokens[draw.randrange(len(tokens))] = draw.choice(WORDS)
            text = " ".join(tokens)
        else:
            lines = text.splitlines(keepends=True)
            draw.shuffle(lines)
            text = "".join(lines[:i] + lines[i // 2 :])[:20_000]
    return text


def mutated_bytes(data: bytes, draw: random.Random) -> bytes:
    """Change one to eight bytes, and end early half the times."""
    changed = bytearray(data)
    for _ in range(draw.randint(1, 8)):
        changed[draw.randrange(len(changed))] = draw.randrange(256)
    return bytes(changed[: draw.choice((len(changed), draw.randrange(len(changed))))])


def mutated_tree(tree: Tree, draw: random.Random) -> Tree:
    """Change one to three values or keys of nested lists and mappings."""
    tree = deepcopy(tree)
    for _ in range(draw.randint(1, 3)):
        branches = _branches(tree)
        if branches:
            _change(draw.choice(branches), branches, draw)
    return tree


def _branches(tree: Tree) -> list[dict[str, Tree] | list[Tree]]:
    """Return all lists and mappings that have something in them."""
    if not isinstance(tree, dict | list) or not tree:
        return []
    inner = tree.values() if isinstance(tree, dict) else tree
    return [tree, *(branch for value in inner for branch in _branches(value))]


def _change(
    branch: dict[str, Tree] | list[Tree],
    branches: list[dict[str, Tree] | list[Tree]],
    draw: random.Random,
) -> None:
    """Change one entry: another value, one of the tree's own, none, or another key."""
    if isinstance(branch, list):
        place = draw.randrange(len(branch))
        value = branch[place]
    else:
        key = draw.choice(list(branch))
        value = branch[key]
    kind = draw.randrange(5)
    if kind == 0:
        value = draw.choice(VALUES)
    elif kind == 1:
        value = _as_another_type(value)
    elif kind == 2:
        value = deepcopy(draw.choice(branches))
    if isinstance(branch, list):
        if kind == 3:
            del branch[place]
        elif kind == 4:
            branch.insert(place, deepcopy(value))
        else:
            branch[place] = value
    elif kind == 3:
        del branch[key]
    elif kind == 4:
        branch[
            draw.choice((*WORDS, *(k for other in branches if isinstance(other, dict) for k in other)))
        ] = value
    else:
        branch[key] = value


def _as_another_type(value: Tree) -> Tree:
    if isinstance(value, str):
        return [value]
    if isinstance(value, bool | int | float):
        return str(value)
    return list(value) if isinstance(value, dict) else None


def mutated_xml(text: str, draw: random.Random) -> bytes:
    """Change an XML: mostly some elements or attributes, so that it stays well formed; else its text."""
    if draw.random() < 0.2:
        return mutated(text, draw).encode("utf-8", errors="surrogatepass")
    root = etree.fromstring(text.encode())
    for _ in range(draw.randint(1, 3)):
        elements = [one for one in root.iter() if isinstance(one.tag, str)]
        _change_element(draw.choice(elements), elements, draw)
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8")


def _change_element(one: etree._Element, elements: list[etree._Element], draw: random.Random) -> None:
    words = [word for word in WORDS if all(c >= " " or c == "\t" for c in word)]
    parent = one.getparent()
    kind = draw.randrange(7)
    if kind <= 2 and one.attrib:
        name = draw.choice(list(one.attrib))
        values = [value for other in elements for value in other.attrib.values()]
        one.attrib[name] = str(draw.choice((*words, *values)))
    elif kind == 3 and one.attrib:
        del one.attrib[draw.choice(list(one.attrib))]
    elif kind == 4:
        other = draw.choice(elements)
        for name, value in other.attrib.items():
            one.attrib[name] = value
    elif kind == 5 and parent is not None:
        parent.remove(one)
    elif kind == 6 and parent is not None:
        draw.choice(elements).append(deepcopy(one))
    else:
        one.text = draw.choice(words)
