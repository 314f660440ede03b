"""
The one validator: from a document to a model, every fault as `file:line: key: what is wrong, got, expected`.

What is wrong is left out, or replaced by its section's stand-in, and the rest is read again: so that one
fault hides no other, neither in the same file nor in what is checked after it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

import yaml
from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from master.errors import ConfigError, Problem, closest, nearest, shown

from .fields import Section, is_nothing
from .sections import field_of, keys_of, section_at
from .yaml_lines import Document, Place

Model = TypeVar("Model", bound=Section)

_MOST_ROUNDS = 20


@dataclass(frozen=True)
class Validated(Generic[Model]):
    """
    What could be read of a document, and its faults.

    `model` is None where too little is left; `document` is without what is wrong.
    """

    model: Model | None
    document: Document
    problems: list[Problem] = field(default_factory=list)


def validated(model: type[Model], document: Document, kind: str) -> Model:
    """
    Read a document as a model; `kind` names it in messages, as `system`.

    Raises:
        ConfigError: With every fault.
    """
    found = validate(model, document, kind)
    if found.problems or found.model is None:
        raise ConfigError(found.problems)
    return found.model


def validate(model: type[Model], document: Document, kind: str) -> Validated[Model]:
    """Read as much of a document as is right, and list its faults."""
    if not isinstance(document.data, dict):
        keys = ", ".join(f.alias or name for name, f in model.model_fields.items() if f.is_required())
        where = document.where(())
        problem = Problem(
            f"not a {kind}", where=where, got=shown(document.data), expected=f"a mapping with {keys}, ..."
        )
        return Validated(None, document, [problem])
    problems: dict[str, Problem] = {}
    repair = _Repair(model, document)
    for _ in range(_MOST_ROUNDS):
        try:
            read = model.model_validate(repair.document.data)
        except ValidationError as error:
            faults = [_Fault.of(model, repair.document, e) for e in error.errors(include_url=False)]
        else:
            return Validated(read, repair.document, [*problems.values()])
        for fault in faults:
            if not repair.has_caused(fault):
                problem = fault.problem(repair.document)
                problems.setdefault(problem.where, problem)
        if not repair.leave_out(faults):
            break
    return Validated(None, repair.document, [*problems.values()])


def problems_of(error: ValidationError, where: str) -> list[Problem]:
    """Faults of data that come from no file, for example from an option."""
    return [
        Problem(what, where=where, got=got, expected=wanted)
        for what, got, wanted in (_words(e, e.get("input")) for e in error.errors(include_url=False))
    ]


@dataclass(frozen=True)
class _Fault:
    """One error of pydantic at its place in the data."""

    place: Place
    section: type[BaseModel] | None
    details: ErrorDetails

    @classmethod
    def of(cls, model: type[BaseModel], document: Document, details: ErrorDetails) -> _Fault:
        place = _data_place(document.data, details["loc"])
        inside = details["type"] in ("missing", "extra_forbidden")
        return cls(place, section_at(model, place[:-1] if inside else place), details)

    @property
    def is_unknown_key(self) -> bool:
        return self.details["type"] == "extra_forbidden"

    @property
    def is_missing(self) -> bool:
        return self.details["type"] == "missing"

    @property
    def is_misspelt(self) -> bool:
        """Whether it is a key that looks like another one."""
        return self.is_unknown_key and closest(str(self.place[-1]), keys_of(self.section)) is not None

    def problem(self, document: Document) -> Problem:
        where = document.where(self.place)
        key = str(self.place[-1]) if self.place else ""
        if self.is_missing:
            return Problem("missing", where=where, expected=_example(self.section, key))
        if self.is_unknown_key:
            got = shown(self.details.get("input"))
            return Problem("unknown key", where=where, got=got, expected=nearest(key, keys_of(self.section)))
        what, got, wanted = _words(self.details, _given(document, self))
        return Problem(what, where=where, got=got, expected=wanted)


_ABSENT = object()


class _Repair:
    """Leaves out what is wrong, and knows which faults that brings about."""

    def __init__(self, model: type[BaseModel], document: Document) -> None:
        self.model = model
        self.document = document
        self.replaced: set[str] = set()
        self.sections: set[str] = set()  # in which something that is meant was left out

    def has_caused(self, fault: _Fault) -> bool:
        """Whether a fault may be there for what was left out only."""
        parents = [self.document.where(fault.place[:n]) for n in range(len(fault.place) + 1)]
        return any(parent in self.sections for parent in parents)

    def leave_out(self, faults: list[_Fault]) -> bool:
        """Leave out the places of faults; False where nothing would be left."""
        doubtful = [f.place[:-1] for f in faults if f.place and not (f.is_unknown_key and not f.is_misspelt)]
        self.sections |= {self.document.where(place) for place in doubtful}
        changes = dict(map(self._change, {f.place for f in faults}))
        if () in changes:
            return False
        for place in sorted(changes, key=_last_first, reverse=True):
            if any(place[:n] in changes for n in range(len(place))):
                continue
            if changes[place] is None:
                self.document = self.document.without(place)
            else:
                self.replaced.add(self.document.where(place))
                self.document = self.document.with_value(place, changes[place])
        return True

    def _change(self, place: Place) -> tuple[Place, Any]:
        """Return what to leave out for a place (value None), or to replace: itself or what holds it."""
        while place:
            section, key = section_at(self.model, place[:-1]), place[-1]
            info = field_of(section, key)
            is_there = self.document.at(place, _ABSENT) is not _ABSENT  # not a key that is missing
            if is_there and (info is None or not info.is_required()):
                return place, None
            if section is not None and issubclass(section, Section):
                stand_in = section.stand_in(str(key), self.document.at(place[:-1]))
                if stand_in is not None and self.document.where(place) not in self.replaced:
                    return place, stand_in
            place = place[:-1]
        return place, None


def _last_first(place: Place) -> list[tuple[int, str]]:
    """Order in which later entries of a list come after earlier ones, and inner places after outer ones."""
    return [(key, "") if isinstance(key, int) else (-1, key) for key in place]


def _example(section: type[BaseModel] | None, key: str) -> str:
    info = field_of(section, key)
    if info is None or not info.examples:
        return "a value"
    line = yaml.safe_dump({key: info.examples[0]}, default_flow_style=True, sort_keys=False, width=1000)
    return f"a value, for example `{line.strip()[1:-1]}`"


def _data_place(data: Any, location: Place) -> Place:
    """Drop from pydantic's location what names a type or a key and is no key of the file."""
    place: list[str | int] = []
    for i, key in enumerate(location):
        last = i == len(location) - 1
        if isinstance(data, dict):
            if key in data:
                data = data[key]
            elif not last or str(key).startswith(("<", "[")):
                continue
        elif isinstance(data, list) and isinstance(key, int) and key < len(data):
            data = data[key]
        else:
            continue
        place.append(key)
    return tuple(place)


def _given(document: Document, fault: _Fault) -> Any:
    """Return what the file holds at the place of a fault; for a key that is wrong, the key."""
    if fault.details["loc"] and fault.details["loc"][-1] == "[key]":
        return str(fault.place[-1])
    return document.at(fault.place, fault.details.get("input"))


_KINDS = {
    "string": ("not a text", "a text"),
    "bool": ("not true or false", "true or false"),
    "int": ("not an integer", "an integer"),
    "float": ("not a number", "a number"),
    "list": ("not a list", "a list"),
    "tuple": ("not a list", "a list"),
    "dict": ("not a mapping", "a mapping"),
    "model": ("not a mapping", "a mapping"),
}
_LIMITS = {
    "greater_than": ("too small", "more than", "gt"),
    "greater_than_equal": ("too small", "at least", "ge"),
    "less_than": ("too large", "less than", "lt"),
    "less_than_equal": ("too large", "at most", "le"),
}


def _words(fault: ErrorDetails, given: Any) -> tuple[str, str, str]:
    """Say what is wrong, what is there, and what belongs there."""
    kind, context = fault["type"], fault.get("ctx", {})
    if kind in _LIMITS:
        what, relation, key = _LIMITS[kind]
        return what, shown(given), f"{relation} {context[key]:.10g}"
    if kind == "too_short":
        return "too few entries", shown(given), f"at least {context['min_length']}"
    if kind == "too_long":
        return "too many entries", shown(given), f"at most {context['max_length']}"
    if kind in ("literal_error", "enum"):
        return "not one of the choices", shown(given), str(context["expected"])
    if kind == "value_error":
        what, _, wanted = str(context["error"]).partition(", expected ")
        kinds = dict(_KINDS.values())
        is_said = ", got " in what or (isinstance(given, dict) and not is_nothing(given))
        return what, "" if is_said else shown(given), wanted or kinds.get(what, "")
    for name, (what, wanted) in _KINDS.items():
        if kind.startswith(name):
            return what, shown(given), wanted
    message = str(fault["msg"])
    return message[0].lower() + message[1:], shown(given), ""
