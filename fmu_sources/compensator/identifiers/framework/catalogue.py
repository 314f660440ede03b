"""All identifiers: each module of the folder above holds its identifier as `IDENTIFIER`."""

from __future__ import annotations

from enum import IntEnum
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from ... import identifiers
from .identifier import Identifier


@cache
def listed() -> tuple[Identifier, ...]:
    """Return all identifiers in the order of their numbers, 1, 2, 3, ..."""
    names = [module.name for module in iter_modules(identifiers.__path__) if not module.ispkg]
    modules = {name: import_module(f"{identifiers.__name__}.{name}") for name in names}
    found = sorted((module.IDENTIFIER for module in modules.values()), key=lambda one: one.number)
    assert {one.name for one in found} == set(names), "an identifier has the name of its file"
    assert [one.number for one in found] == list(range(1, len(found) + 1)), "numbers have no gap"
    return tuple(found)


_NUMBERS = {one.name: one.number for one in listed()}
IdentifierChoice: type[IntEnum] = IntEnum("Identifier", _NUMBERS)  # type: ignore[misc]  # not literal
