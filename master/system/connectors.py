"""Inputs and outputs of the whole system, described as those of an FMU are: wires lead to both alike."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator

from master.errors import Problem
from master.fmi import value_types
from master.fmi.description import Description, Kind, Variable
from master.fmi.unit_names import unit as unit_named
from master.fmi.units import Unit
from master.text.signal_name import SignalName

from .config import LoadedConfig, SystemConnector

_KINDS = {"real": Kind.REAL, "integer": Kind.INTEGER, "boolean": Kind.BOOLEAN, "string": Kind.STRING}
_VALUE_TYPES = {
    Kind.REAL: value_types.FLOAT64,
    Kind.INTEGER: value_types.INT64,
    Kind.BOOLEAN: value_types.BOOLEAN,
    Kind.STRING: value_types.BOOLEAN,
}


def described_connectors(
    loaded: LoadedConfig, fmus: Collection[str], problems: list[str]
) -> dict[str, Description]:
    """Describe the connectors by their owners: the system itself, and recordings of an archive."""
    given = {SignalName(name): entry for name, entry in loaded.config.connectors.items()}
    found: dict[str, list[Variable]] = {}
    for name, entry in given.items():
        if name.instance in fmus:
            where = loaded.where("connectors", name)
            got = f"{name.instance!r}, an FMU"
            problems.append(Problem("not a name for the system", where=where, got=got, expected="another"))
        else:
            variables = found.setdefault(name.instance, [])
            variables += _variables(name, entry, loaded.units.get(name))
    return {
        owner: Description(
            path=loaded.document.path,
            fmi_version="0",
            model_name="the system",
            model_identifier="",
            token="",
            variables=tuple(variables),
        )
        for owner, variables in found.items()
    }


def _variables(signal: SignalName, entry: SystemConnector, unit: Unit | None) -> Iterator[Variable]:
    """One variable, or one for each element of an array; `unit` is one that the file itself defines."""
    name, kind = signal.variable, _KINDS[entry.type]
    indices = itertools.product(*(range(1, n + 1) for n in entry.shape))
    elements = [f"{name}[{','.join(map(str, index))}]" for index in indices] if entry.shape else [name]
    for i, element in enumerate(elements):
        yield Variable(
            name=element,
            reference=0,
            kind=kind,
            value_type=_VALUE_TYPES[kind],
            causality=entry.kind,
            variability="tunable" if entry.kind == "parameter" else "discrete",
            unit=_unit(entry.unit) if unit is None and entry.unit is not None else unit,
            items=entry.items,
            size=len(elements),
            element=i if entry.shape else None,
            array=name if entry.shape else None,
        )


def _unit(name: str) -> Unit:
    """Return the unit that a name says; any other fits its own name only."""
    try:
        return unit_named(name)
    except ValueError:
        return Unit(name, defined=False)
