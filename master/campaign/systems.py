"""From the values of a run to the system that is stepped; what runs share is prepared once."""

from __future__ import annotations

import copy
import json
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from master.api import prepare_to_run
from master.catalogue import is_path
from master.comparison.cells import Cell
from master.comparison.methods import all_methods
from master.comparison.systems import Base, put_method
from master.errors import ConfigError, Problem, nearest
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request
from master.system.config import Config, LoadedConfig
from master.system.graph import with_values
from master.text.validation import validate
from master.text.yaml_lines import Document, Place

from .target import METHOD, Target

_MOST_PREPARED = 64


@dataclass(frozen=True)
class Varied:
    """A system that varies: what was read, how it was asked for, and what is prepared of it as it is."""

    loaded: LoadedConfig
    request: Request
    base: Experiment
    targets: Mapping[str, Target]

    @property
    def is_structural(self) -> bool:
        """Whether what varies changes more than values of FMUs."""
        return any(target.is_structural for target in self.targets.values())

    def document(self, values: Mapping[str, Any]) -> Document:
        """
        Return the system's document with the values that are places of it.

        Raises:
            ConfigError: If a method is none, or the system is none that methods are for.
        """
        document = self.loaded.document
        data = copy.deepcopy(document.data)
        for key, value in values.items():
            target = self.targets[key]
            if key == METHOD:
                data = _with_method(data, document.path, str(value))
            elif target.place:
                _put(data, target.place, value)
        return replace(document, data=data)

    def settings(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values of variables, `instance.variable` to value."""
        return {signal: value for key, value in values.items() for signal in self.targets[key].signals}


class Systems:
    """Experiments of runs; those whose structure was prepared before are at hand."""

    def __init__(self, varied: Varied) -> None:
        self._varied = varied
        self._prepared: OrderedDict[str, Experiment] = OrderedDict()

    def experiment(self, values: Mapping[str, Any]) -> Experiment:
        """
        Return the experiment of a run.

        Args:
            values: By key of `vary`, in the units of the targets.

        Raises:
            ConfigError: With what does not fit.
            FmuError: If a phase lead is designed and an FMU fails in that.
        """
        targets = self._varied.targets
        structural = {key: value for key, value in values.items() if targets[key].is_structural}
        plain = {key: value for key, value in values.items() if key not in structural}
        base = self._varied.base if not structural else self._structured(structural)
        system = with_values(base.system, self._varied.settings(plain))
        return replace(base, system=system)

    def _structured(self, values: Mapping[str, Any]) -> Experiment:
        key = json.dumps(values, sort_keys=True, default=str)
        if key in self._prepared:
            self._prepared.move_to_end(key)
            return self._prepared[key]
        found = prepared(self._varied, values)
        self._prepared[key] = found
        if len(self._prepared) > _MOST_PREPARED:
            self._prepared.popitem(last=False)
        return found


def prepared(varied: Varied, values: Mapping[str, Any]) -> Experiment:
    """
    Prepare the system of some values from its document on, as `dockloop run` does.

    Raises:
        ConfigError: With what does not fit.
    """
    document = varied.document(values)
    found = validate(Config, document, "system")
    if found.model is None:
        raise ConfigError(found.problems)
    loaded = replace(varied.loaded, config=found.model, document=found.document, problems=found.problems)
    given = tuple(f"{signal}={json.dumps(value)}" for signal, value in varied.settings(values).items())
    request = replace(varied.request, assignments=(*varied.request.assignments, *given))
    return prepare_to_run(loaded, request)


def portable(document: Document) -> dict[str, Any]:
    """Return the data of a document that may lie in another folder: paths in it are absolute."""
    data: dict[str, Any] = copy.deepcopy(document.data)
    folder = document.path.parent.absolute()
    for entry in data.get("fmus", {}).values():
        if is_path(str(entry.get("source", ""))):
            entry["source"] = str(folder / str(entry["source"]))
    inputs = data.get("inputs") or []
    for entry in inputs if isinstance(inputs, list) else [inputs]:
        entry["file"] = str(folder / str(entry["file"]))
    return data


def _put(data: Any, place: Place, value: Any) -> None:
    """Put a value at a place; the section `coupling` is made where it is missing."""
    for key in place[:-1]:
        if isinstance(data, dict) and data.get(key) is None:
            data[key] = {}
        data = data[key]
    data[place[-1]] = value


def _with_method(data: dict[str, Any], path: Path, name: str) -> dict[str, Any]:
    methods = all_methods()
    if name not in methods:
        raise ConfigError(
            [Problem("no such method", where=METHOD, got=repr(name), expected=nearest(name, methods))]
        )
    data.pop("variants", None)
    put_method(data, Base(path), Cell(), methods[name])
    return data
