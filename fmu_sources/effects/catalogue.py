"""All effects by name: each `<name>.py` of this folder holds its effect as `EFFECT`."""

from __future__ import annotations

import importlib
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from ..framework.model import Slot
from .framework.effect import Effect
from .framework.roles import fits
from .learned import FIRST, SECOND, learned

_LEARNED = re.compile(f"learned_({'|'.join(FIRST)})_({'|'.join(SECOND)})")


@cache
def listed() -> Mapping[str, Effect]:
    """Effects that have a name of their own, in alphabetical order; `learned` ones are not among them."""
    files = sorted(Path(__file__).parent.glob("*.py"))
    names = [f.stem for f in files if "\nEFFECT = " in f.read_text(encoding="utf-8")]
    return {name: _load(name) for name in names}


def effect(name: str) -> Effect:
    """Find an effect by name, also `learned_<first>_<second>`; KeyError if there is none."""
    parts = _LEARNED.fullmatch(name)
    return learned(parts[1], parts[2]) if parts else listed()[name]


def file_of(name: str) -> str:
    """Name of the module, in this folder, that holds an effect; KeyError if there is none."""
    return effect(name).law.__module__.rpartition(".")[2]


def constant() -> Effect:
    """Return the effect that adds a constant to the value, and does nothing else."""
    return next(e for e in listed().values() if e.constant is not None)


def candidates(slot: Slot) -> list[Effect]:
    """List the named effects that fit a slot."""
    return [e for e in listed().values() if fits(e, slot)]


def _load(name: str) -> Effect:
    found = importlib.import_module(f".{name}", __package__).EFFECT
    assert isinstance(found, Effect)
    assert found.name == name
    return found
