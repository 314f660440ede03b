"""What a key of `vary` changes: a variable of an FMU, a place of the system's file, the method, the seeds."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from master.errors import Problem, nearest
from master.experiment.experiment import Experiment
from master.fmi.description import Variable
from master.fmi.unit_names import unit
from master.fmi.units import Unit
from master.fmi.values import named_by
from master.system.config import Config, LoadedConfig
from master.system.graph import signal_fault
from master.text.yaml_lines import Place

METHOD, SEED = "method", "seed"
_SECONDS = ("at", "for", "step_size", "start_time", "stop_time")
_KEYS = re.compile(r"([^.\[\]]+)|\[([^\]]+)\]")
_WHOLE = re.compile(r"[^.\[\]]+(\.[^.\[\]]+|\[[^\]]+\])*")


@dataclass(frozen=True)
class Target:
    """
    What a key changes.

    `signals` are variables that get the value, `place` a place of the document; of both, one is empty.
    `unit` is that of the value, None where it has none. `is_structural`: the system has to be read again.
    """

    key: str
    signals: tuple[str, ...] = ()
    place: Place = ()
    unit: Unit | None = None
    is_structural: bool = False


def target(key: str, loaded: LoadedConfig, base: Experiment) -> Target:
    """
    Find what a key changes.

    Raises:
        ValueError: With a Problem, if it names nothing.
    """
    if key == METHOD:
        return Target(key, place=(METHOD,), is_structural=True)
    if key == SEED:
        return _seeds(base)
    head = key.partition(".")[0].partition("[")[0]
    descriptions = base.system.descriptions
    if head in Config.model_fields and head not in descriptions:
        return _place(key, loaded)
    fault = signal_fault(descriptions, key, None)
    instance, _, name = key.partition(".")
    described = descriptions.get(instance)
    variables = () if described is None else named_by(described, name)
    if fault is not None and not variables:
        raise ValueError(_with_places(fault))
    known = variables[0] if variables else None
    return Target(
        key,
        signals=(key,),
        unit=None if known is None else known.unit,
        is_structural=_is_structural(known) or (base.phase_lead is not None and not base.is_designed),
    )


def _with_places(fault: Problem) -> Problem:
    expected = (
        f"{fault.expected}; or `seed`, `method`, a place of the system's file as `connections[...].delay`"
    )
    return Problem(fault.what, where=fault.where, got=fault.got, expected=expected)


def _is_structural(variable: Variable | None) -> bool:
    return variable is not None and variable.is_structural


def _seeds(base: Experiment) -> Target:
    """All parameters called `seed`."""
    names = [
        f"{name}.{SEED}"
        for name, instance in base.system.instances.items()
        if SEED in instance.description.by_name and instance.description.by_name[SEED].is_settable
    ]
    if not names:
        raise ValueError(Problem("no FMU has a parameter of this name", got=repr(SEED)))
    return Target(SEED, signals=tuple(names))


def _place(key: str, loaded: LoadedConfig) -> Target:
    """Find a place of the document, named as messages name it; a connection also by its target."""
    if _WHOLE.fullmatch(key) is None:
        raise ValueError(Problem("not a place", got=repr(key), expected="a place as `connections[0].delay`"))
    place: list[str | int] = []
    data: Any = loaded.document.data
    parts = [m.group(1) or f"[{m.group(2)}]" for m in _KEYS.finditer(key)]
    for i, part in enumerate(parts):
        step: str | int = part
        if part.startswith("["):
            step = _index(part[1:-1], data, key)
        place.append(step)
        is_last = i == len(parts) - 1
        if isinstance(step, int) or (isinstance(data, dict) and step in data):
            data = data[step]
        elif not is_last and not (i == 0 and step == "coupling"):
            known = [*data] if isinstance(data, dict) else []
            raise ValueError(Problem("no such place", got=repr(key), expected=nearest(part, map(str, known))))
        else:
            data = {}
    own = unit("s") if parts[-1] in _SECONDS else None
    return Target(key, place=tuple(place), unit=own, is_structural=True)


def _index(text: str, data: Any, key: str) -> int:
    """Place in a list: a number, or for a connection the signal that it leads to."""
    if not isinstance(data, list):
        raise ValueError(Problem("no such place", got=repr(key), expected="a list before the brackets"))
    if text.isdecimal() and int(text) < len(data):
        return int(text)
    ends = [str(entry.get("to", "")) if isinstance(entry, dict) else "" for entry in data]
    if text in ends:
        return ends.index(text)
    numbers = f"a number below {len(data)}" if data else "an entry of a list, which is empty"
    named = f", or a target: {nearest(text, filter(None, ends))}" if any(ends) else ""
    raise ValueError(Problem("no such entry", got=repr(key), expected=numbers + named))
