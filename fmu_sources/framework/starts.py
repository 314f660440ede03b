"""A model with other start values: what was identified, as what an FMU starts from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from .model import Model


def with_starts(model: Model, starts: Mapping[str, float]) -> Model:
    """
    Return a model with other start values of some of its variables; its equations and its name stay.

    Raises:
        ValueError: If it has no such variable.
    """
    known = {v.name for v in model.variables}
    unknown = sorted(set(starts) - known)
    if unknown:
        raise ValueError(
            f"{model.name}: no such variable, got {unknown[0]!r}, expected one of {sorted(known)}"
        )
    kind = type(model)
    variables = tuple(replace(v, start=starts.get(v.name, v.start)) for v in model.variables)
    attributes = {"__module__": kind.__module__, "__doc__": kind.__doc__, "variables": variables}
    changed: Model = type(kind.__name__, (kind,), attributes)()
    return changed
