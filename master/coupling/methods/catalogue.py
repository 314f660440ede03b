"""The coupling methods found in this folder, and how an entry of `coupling.order` becomes one of them."""

from __future__ import annotations

import inspect
import pkgutil
from functools import reduce
from importlib import import_module
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Discriminator, Field, Tag

from .method import Method
from .side_by_side import SideBySide

_ONE, _LIST, _UNKNOWN = "<one>", "<side by side>", "<unknown>"


def _methods() -> dict[str, type[Method]]:
    """All methods that are written as a mapping, by their key."""
    found: dict[str, type[Method]] = {}
    for module in sorted(m.name for m in pkgutil.iter_modules([str(Path(__file__).parent)])):
        for _, kind in inspect.getmembers(import_module(f"{__package__}.{module}"), inspect.isclass):
            if issubclass(kind, Method) and kind.key:
                found[kind.key] = kind
    return found


METHODS = _methods()


def _form(entry: Any) -> str:
    """Tag of the form of an entry of `coupling.order`."""
    if isinstance(entry, str):
        return _ONE
    if isinstance(entry, list | tuple):
        return _LIST
    if isinstance(entry, Method):
        return f"<{entry.key}>"
    keys = [key for key in METHODS if isinstance(entry, dict) and key in entry]
    return f"<{keys[0]}>" if keys else _UNKNOWN


_MAPPINGS = [Annotated[kind, Tag(f"<{key}>")] for key, kind in METHODS.items()]
_NAMES = Annotated[list[str], Field(min_length=1), Tag(_LIST)]
_FORMS = reduce(or_, [_NAMES, *_MAPPINGS], Annotated[str, Tag(_ONE)])

if TYPE_CHECKING:
    OrderEntry = str | list[str] | Method
else:
    OrderEntry = Annotated[
        _FORMS,
        Discriminator(
            _form,
            custom_error_type="not_a_coupling_method",
            custom_error_message="not an entry of the order, expected a name, a list of names or a mapping "
            f"with {' or '.join(METHODS)}",
        ),
    ]
"""An entry as pydantic reads it: a name, a list of names, or one of the methods found here."""


def method_of(entry: str | list[str] | Method) -> Method:
    """Return the method of an entry of `coupling.order`."""
    if isinstance(entry, Method):
        return entry
    return SideBySide(members=(entry,) if isinstance(entry, str) else tuple(entry))
