"""The sections of a model by their place: which model is where, which keys it has."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, get_args, get_origin

from pydantic import BaseModel

from .yaml_lines import Place


def section_at(model: Any, place: Place) -> type[BaseModel] | None:
    """Model of the section at a place, of one entry where a list is; None if there is none."""
    for key in place:
        model = _inner(model, key)
    entries = (get_args(one)[0] for one in _alternatives(model) if get_origin(one) is list)
    return next((m for one in (model, *entries) for m in _models(one)), None)


def _inner(annotation: Any, key: str | int) -> Any:
    """Annotation of an entry: a field of a model, an entry of a list or of a mapping."""
    for model in _models(annotation):
        info = field_of(model, key)
        return None if info is None else info.annotation
    for inner in _alternatives(annotation):
        origin, arguments = get_origin(inner), get_args(inner)
        if origin is dict and isinstance(key, str):
            return arguments[1]
        if origin in (list, tuple) and isinstance(key, int):
            return arguments[min(key, len(arguments) - 1)]
        if origin is list:  # one entry that is written without the list
            return _inner(arguments[0], key)
    return None


def _alternatives(annotation: Any) -> Iterator[Any]:
    """Members of a union, without annotations."""
    origin = get_origin(annotation)
    if origin in (None, dict, list, tuple):
        yield annotation
        return
    for argument in get_args(annotation):
        yield from _alternatives(argument)


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    for inner in _alternatives(annotation):
        if isinstance(inner, type) and issubclass(inner, BaseModel):
            yield inner


def field_of(section: type[BaseModel] | None, key: str | int) -> Any:
    """Field of a section by its key; None if there is none."""
    if section is None:
        return None
    for name, info in section.model_fields.items():
        if key in (info.alias, name):
            return info
    return None


def keys_of(section: type[BaseModel] | None) -> list[str]:
    """Keys that a section may have."""
    return [] if section is None else [f.alias or name for name, f in section.model_fields.items()]
