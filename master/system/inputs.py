"""Inputs that a recording drives: the value of each at every tick, and every fault of file and columns."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from master.errors import ConfigError, expected
from master.fmi.description import Kind
from master.fmi.unit_names import unit as unit_named
from master.fmi.units import Conversion, Unit, conversion

from .config import LoadedConfig, MeasuredColumn
from .graph import Instance, System
from .grid import Grid

if TYPE_CHECKING:
    from .input_reader import Floats


@dataclass(frozen=True)
class Feed:
    """One input under a recording; `source` names file and column."""

    source: str
    target: str


@dataclass(frozen=True)
class MeasuredInputs:
    """
    All inputs under recordings.

    `values` has a row for each tick and one more, shape (ticks + 1, inputs), in the units of the inputs: row
    k holds those at t_k. An input has them as from an FMU that steps before all others.
    """

    feeds: tuple[Feed, ...] = ()
    values: Floats | None = None

    @property
    def columns(self) -> dict[str, int]:
        """Column of each input."""
        return {feed.target: i for i, feed in enumerate(self.feeds)}


def measured_inputs(loaded: LoadedConfig, system: System, grid: Grid) -> MeasuredInputs:
    """
    Read the recordings of a system.

    Raises:
        ConfigError: With every fault of a file, a column, a unit or an input.
    """
    if not loaded.config.inputs:  # most systems have none, and need not wait for numpy
        return MeasuredInputs()
    import numpy as np

    from .input_reader import InputReader

    problems: list[str] = []
    feeds: list[Feed] = []
    values: list[Floats] = []
    for i, given in enumerate(loaded.config.inputs):
        reader = InputReader(loaded, i, given, grid, problems)
        for signal, column in given.map.items():
            conversion_ = _checked(loaded, i, signal, column, system, {f.target for f in feeds}, problems)
            found = reader.column(column, loaded.where("inputs", i, "map", signal, "column"))
            if conversion_ is not None and found is not None:
                feeds.append(Feed(f"{given.file}: {column.column}", signal))
                values.append(conversion_.factor * found + conversion_.offset)
    if problems:
        raise ConfigError(dict.fromkeys(problems))
    return MeasuredInputs(tuple(feeds), np.column_stack(values)) if feeds else MeasuredInputs()


def with_first_values(system: System, inputs: MeasuredInputs) -> System:
    """Let each input under a recording begin with its first value."""
    if inputs.values is None:
        return system
    instances: dict[str, Instance] = dict(system.instances)
    for feed, value in zip(inputs.feeds, inputs.values[0], strict=True):
        name, _, variable = feed.target.partition(".")
        start = {**instances[name].start, variable: float(value)}
        instances[name] = replace(instances[name], start=start)
    return replace(system, instances=instances)


def _checked(
    loaded: LoadedConfig,
    i: int,
    signal: str,
    column: MeasuredColumn,
    system: System,
    fed: set[str],
    problems: list[str],
) -> Conversion | None:
    """Return the conversion of a column for an input; None, with a problem, if it cannot be driven."""
    where = loaded.where("inputs", i, "map", signal)
    instance, _, name = signal.partition(".")
    if instance not in system.instances:
        problems.append(f"{where}: no such FMU, got {instance!r}, {expected(instance, system.instances)}")
        return None
    known = system.instances[instance].description.by_name
    inputs = [v.name for v in known.values() if v.causality == "input" and v.kind is not Kind.STRING]
    if name not in inputs:
        problems.append(f"{where}: no such input, got {name!r}, {expected(name, inputs)}")
        return None
    if signal in fed or signal in {w.target.name for w in system.wires}:
        problems.append(f"{where}: has two sources, got {signal!r} again, expected one wire or one column")
        return None
    if any(signal in event.set for event in loaded.config.events):
        problems.append(f"{where}: an event sets {signal!r} too, expected one of both")
        return None
    return _conversion(column, known[name].unit, where, problems)


def _conversion(
    column: MeasuredColumn, target: Unit | None, where: str, problems: list[str]
) -> Conversion | None:
    if column.unit is None:
        return Conversion()
    try:
        named = unit_named(column.unit)
    except ValueError as error:
        problems.append(f"{where}: {error}")
        return None
    found = conversion(Unit(column.unit, named.exponents, named.factor), target)
    if found is None:
        expected_unit = "none" if target is None else target.name
        problems.append(f"{where}: unit does not fit, got {column.unit!r}, expected {expected_unit}")
    return found
