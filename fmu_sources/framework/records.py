"""Flat lists of numbers as records with named fields, and back."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, Mapping, Sequence
from operator import itemgetter
from typing import Any

from .variables import Variable


def _all_of(keys: Sequence[Any]) -> Callable[[Any], Sequence[Any]]:
    """Return what takes the items at all keys, in their order; records are made in every substep."""
    if len(keys) > 1:
        return itemgetter(*keys)
    return lambda items: [items[key] for key in keys]


class RecordType:
    """Fields of one group of variables; elements `name[1]`, `name[2]`, ... form the tuple field `name`."""

    def __init__(self, title: str, variables: Sequence[Variable]) -> None:
        self.names = [v.name for v in variables]
        self.fields: dict[str, slice] = {}
        for i, v in enumerate(variables):
            first = self.fields[v.base].start if v.base in self.fields else i
            self.fields[v.base] = slice(first, i + 1)
        scalar = {base: variables[place.start].name == base for base, place in self.fields.items()}
        places = [place.start if scalar[base] else place for base, place in self.fields.items()]
        self._type: Any = namedtuple(title, self.fields)  # type: ignore[misc]
        self._flat = all(scalar.values())
        self._fields_of = _all_of(places)
        self._values_of = _all_of(list(self.fields))

    def __len__(self) -> int:
        """Count the numbers."""
        return len(self.names)

    def record(self, values: Sequence[Any]) -> Any:
        """View a flat list, shape (len(self),), as a record."""
        return self._type._make(values if self._flat else self._fields_of(tuple(values)))

    def flat(self, fields: Mapping[str, Any]) -> list[Any]:
        """Put all fields into a flat list; a missing one is a KeyError."""
        if self._flat:
            return list(self._values_of(fields))
        return self.merged(fields, [None] * len(self), complete=True)

    def merged(self, fields: Mapping[str, Any], old: Sequence[Any], *, complete: bool = False) -> list[Any]:
        """Put the given fields over the old numbers."""
        new = list(old)
        for name in self.fields if complete else fields:
            place = self.fields[name]
            if self.names[place.start] == name:
                new[place.start] = fields[name]
            else:
                assert len(fields[name]) == place.stop - place.start, name
                new[place] = fields[name]
        return new
