"""
The reference pages of the site, made from the code when the site is built: nothing in them is written twice.

MkDocs calls `on_files` (`hooks` in `mkdocs.yml`); tests call `pages`.
"""

from __future__ import annotations

import importlib
import inspect
import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

import click

import dockloop
from fmu_sources.composed import registry
from fmu_sources.effects import catalogue
from master.cli import COMMANDS, GROUPS, main
from master.diagnosis.case.case import Case
from master.system.config import Config
from master.text.schema import json_schema


def on_files(files: Any, config: Any) -> Any:
    """Add the pages to those of the folder."""
    from mkdocs.structure.files import File

    for path, text in pages().items():
        files.append(File.generated(config, path, content=text))
    return files


def pages() -> dict[str, str]:
    """Return the text of each page by its path."""
    return {
        "reference/system.md": _keys("Keys of a system", json_schema(Config, "system")),
        "reference/case.md": _keys("Keys of a case", json_schema(Case, "case")),
        "reference/commands.md": commands(),
        "reference/python.md": python_api(),
        "reference/models.md": models(),
        "reference/effects.md": effects(),
    }


def _keys(title: str, schema: Mapping[str, Any]) -> str:
    """Return a table for each section: key, what it takes, default."""
    lines = [f"# {title}", "", str(schema.get("description", "")), "", *_table(schema)]
    for name, section in schema.get("$defs", {}).items():
        lines += ["", f"## {name}", "", _paragraphs(section.get("description", "")), "", *_table(section)]
    return "\n".join(lines) + "\n"


def _table(section: Mapping[str, Any]) -> list[str]:
    if "properties" not in section:
        return [_kind(section)]
    required = section.get("required", ())
    lines = ["| key | takes | default |", "|---|---|---|"]
    for key, value in section["properties"].items():
        default = "required" if key in required else _default(value)
        lines.append(f"| `{key}` | {_kind(value)} | {default} |")
    return lines


def _default(value: Mapping[str, Any]) -> str:
    default = value.get("default")
    return "none" if default in (None, [], {}, "") else f"`{json.dumps(default)}`"


def _kind(value: Mapping[str, Any]) -> str:
    """What a key takes, in words; sections are links."""
    if "$ref" in value:
        name = value["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    for many in ("anyOf", "oneOf"):
        if many in value:
            kinds = [_kind(one) for one in value[many] if one.get("type") != "null"]
            return " or ".join(dict.fromkeys(kinds))
    if "enum" in value or "const" in value:
        return ", ".join(f"`{one}`" for one in value.get("enum", [value.get("const")]))
    match value.get("type"):
        case "array":
            return f"list of: {_kind(value['items'])}" if "items" in value else "list"
        case "object":
            content = value.get("additionalProperties")
            return f"mapping of names to: {_kind(content)}" if isinstance(content, dict) else "mapping"
        case str(kind):
            return kind + _bounds(value)
    return "any value"


def _bounds(value: Mapping[str, Any]) -> str:
    signs = {"minimum": ">=", "maximum": "<=", "exclusiveMinimum": ">", "exclusiveMaximum": "<"}
    said = [f"{sign} {value[key]:g}" for key, sign in signs.items() if key in value]
    return f" {', '.join(said)}" if said else ""


def commands() -> str:
    """Return the help of every command, by group."""
    lines = ["# Commands", ""]
    for title, names in GROUPS.items():
        lines += [f"## {title.capitalize()}", ""]
        for name in names:
            command = main.get_command(click.Context(main, info_name="dockloop"), name)
            assert command is not None
            shown = click.Context(command, info_name=f"dockloop {name}", terminal_width=100)
            lines += [f"### {name}", "", *_code(command.get_help(shown)), ""]
    missing = set(COMMANDS) - {name for names in GROUPS.values() for name in names}
    assert not missing, f"commands without a group: {missing}"
    return "\n".join(lines)


def python_api() -> str:
    """Return signature and docstring of every public name of `dockloop`, classes with their members."""
    lines = ["# Python", "", *_code(inspect.getdoc(dockloop) or ""), ""]
    for name in dockloop.__all__:
        thing = getattr(dockloop, name)
        lines += [f"## {name}", "", *_code(f"{_signature(name, thing)}\n\n{inspect.getdoc(thing) or ''}"), ""]
        if inspect.isclass(thing) and thing.__module__.startswith("dockloop"):
            for member, value in _members(thing):
                text = f"{_signature(member, value)}\n\n{inspect.getdoc(value) or ''}"
                lines += [f"### {name}.{member}", "", *_code(text), ""]
    return "\n".join(lines)


def _members(thing: type) -> Iterator[tuple[str, Any]]:
    for name, value in vars(thing).items():
        if not name.startswith("_") and (callable(value) or isinstance(value, property)):
            yield name, value


def _signature(name: str, thing: Any) -> str:
    try:
        return f"{name}{inspect.signature(thing)}"
    except (TypeError, ValueError):
        return name


def models() -> str:
    """Return the text of every model: equations, symbols, source, deviations."""
    lines = ["# Models", ""]
    for name, path in registry.model_files().items():
        module = importlib.import_module(f"fmu_sources.{path.parent.name}.{name}")
        lines += [f"## {name}", "", module.MODEL.description, "", *_code(inspect.getdoc(module) or ""), ""]
    return "\n".join(lines)


def effects() -> str:
    """Return the text of every effect: law, parameters, source, limits."""
    lines = [
        "# Effects",
        "",
        "Laws that a model may lack, as `slots` of a case and `source` of an FMU name them.",
        "",
    ]
    for name in catalogue.listed():
        module = importlib.import_module(f"fmu_sources.effects.{name}")
        lines += [f"## {name}", "", *_code(inspect.getdoc(module) or ""), ""]
    return "\n".join(lines)


def _code(text: str) -> list[str]:
    fence = "````" if "```" in text else "```"
    return [f"{fence}text", text.rstrip(), fence]


def _paragraphs(text: str) -> str:
    return re.sub(r"\n(?!\n)", " ", text)
