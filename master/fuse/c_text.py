"""Text of C files: which names they declare, how these get a prefix, which functions are left out."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

_SPECIAL = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\])*"', re.DOTALL)
_IDENTIFIER = re.compile(r"(?<!\w)[A-Za-z_]\w*")
_MACRO = re.compile(r"^#define\s+(\w+)", re.MULTILINE)
_DIRECTIVE = re.compile(r"^#(?:[^\n]*\\\n)*[^\n]*$", re.MULTILINE)
_ENUMERATION = re.compile(r"\benum\b\s*\w*\s*\{([^}]*)\}")
_ATTRIBUTE = re.compile(r"__attribute__\s*\(\(.*?\)\)")
_POINTER_TO_FUNCTION = re.compile(r"\(\*\s*(\w+)\)")
_BEFORE_ARGUMENTS = re.compile(r"(\w+)\s*\(")
_OBJECT = re.compile(r"(\w+)\s*(?:\[[^=]*\])*\s*(?:=.*)?$", re.DOTALL)
_TAG = re.compile(r"\bstruct\s+(\w+)")


def declared_names(text: str) -> set[str]:
    """Collect what a C text declares: functions, objects, types, tags, constants, macros."""
    plain = _ATTRIBUTE.sub("", _SPECIAL.sub(_blank, text))
    names = set(_MACRO.findall(plain))
    plain = _DIRECTIVE.sub("", plain)
    for body in _ENUMERATION.findall(plain):
        names |= {part.partition("=")[0].strip() for part in body.split(",")} - {""}
    for declaration in _declarations(plain):
        names |= set(_TAG.findall(declaration))
        name = _declared(declaration)
        if name is not None:
            names.add(name)
    return names


def with_prefix(text: str, names: Iterable[str], prefix: str) -> str:
    """Put a prefix before names, but not within strings, comments and names of files."""
    chosen = frozenset(names)

    def renamed(part: str) -> str:
        return _IDENTIFIER.sub(lambda m: prefix + m[0] if m[0] in chosen else m[0], part)

    parts, end = [], 0
    for special in _SPECIAL.finditer(text):
        parts += [renamed(text[end : special.start()]), special[0]]
        end = special.end()
    return "".join([*parts, renamed(text[end:])])


def without_functions(text: str, names: Iterable[str]) -> str:
    """
    Leave out the definitions of functions.

    Raises:
        ValueError: If one of them is not there.
    """
    for name in names:
        definition = rf"^(?! )[^\n(;=]*\b{name}\([^;{{]*\{{\n.*?^\}}\n\n?"
        text, found = re.subn(definition, "", text, count=1, flags=re.MULTILINE | re.DOTALL)
        if not found:
            raise ValueError(f"no function {name}")
    return text


def joined(files: Iterable[str]) -> str:
    """Join C files to one, without their includes of files of their own; of the system's, each once."""
    texts = [re.sub(r'^#include "[^"]*"[^\n]*\n', "", text, flags=re.MULTILINE) for text in files]
    includes = dict.fromkeys(line for text in texts for line in re.findall(r"^#include <[^\n]*", text, re.M))
    bodies = [re.sub(r"^#include <[^\n]*\n", "", text, flags=re.MULTILINE).strip() for text in texts]
    return "\n".join(includes) + "\n\n" + "\n\n".join(bodies) + "\n"


def _blank(special: re.Match[str]) -> str:
    """Put an empty string in the place of a string, a blank in that of a comment."""
    return '""' if special[0].startswith('"') else " "


def _declarations(text: str) -> Iterator[str]:
    """Parts of a text that stand outside of all braces, without what stands within."""
    depth, part = 0, ""
    for character in text:
        if character == "}":
            depth -= 1
            if depth == 0 and "(" in part and "=" not in part:  # the end of a function
                yield part
                part = ""
        elif depth == 0 and character == ";":
            yield part
            part = ""
        elif character == "{":
            depth += 1
        elif depth == 0:
            part += character


def _declared(declaration: str) -> str | None:
    """Return the name that a declaration is of; None where it has only a tag or constants."""
    declaration = " ".join(declaration.split())
    if "=" not in declaration and "(" in declaration:
        pointer = _POINTER_TO_FUNCTION.search(declaration)
        function = pointer or _BEFORE_ARGUMENTS.search(declaration)
        return None if function is None else function[1]
    found = _OBJECT.search(declaration)
    is_nameless = declaration.split()[:1] in (["enum"], ["struct"]) and len(declaration.split()) < 2
    return None if found is None or is_nameless else found[1]
