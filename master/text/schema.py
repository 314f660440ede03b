"""JSON Schemas of the files that people write, for editors: keys, values and what they mean."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

DIALECT = "https://json-schema.org/draft/2020-12/schema"
ONE_OR_MORE: Any = {"one_or_more": True}
"""Of a list that may be written as its only entry; see `json_schema_extra` of a field."""


class OrText:
    """Marks a section that may be written as a text alone, such as the path of a file."""

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        """Allow the text next to the section."""
        return {"anyOf": [{"type": "string"}, handler(core)]}


def json_schema(model: type[BaseModel], title: str) -> dict[str, Any]:
    """
    Return the schema of a file.

    A key that may be left out may have no value, too; an editor is told so.
    """
    found = _written(model.model_json_schema(by_alias=True))
    assert isinstance(found, dict)
    return {"$schema": DIALECT, **found, "title": title}


def _written(node: Any) -> Any:
    """Turn what a checked section holds into what people may write."""
    if isinstance(node, list):
        return [_written(part) for part in node]
    if not isinstance(node, dict):
        return node
    changed = {key: _written(value) for key, value in node.items() if key != "one_or_more"}
    if node.get("one_or_more"):
        rest = {key: value for key, value in changed.items() if key not in ("items", "type")}
        changed = {**rest, "anyOf": [changed["items"], {"type": "array", "items": changed["items"]}]}
    if "properties" in node and isinstance(node["properties"], dict):
        required = node.get("required", ())
        changed["properties"] = {
            key: value if key in required else _or_nothing(value)
            for key, value in changed["properties"].items()
        }
    changed.pop("title", None)
    return changed


def _or_nothing(schema: dict[str, Any]) -> dict[str, Any]:
    """Let a key be written without a value."""
    if {"type": "null"} in schema.get("anyOf", ()):
        return schema
    told: dict[str, Any] = {key: schema[key] for key in ("description", "default") if key in schema}
    return {"anyOf": [{k: v for k, v in schema.items() if k not in told}, {"type": "null"}], **told}
