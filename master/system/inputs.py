"""Inputs that a recording drives: the value of each at every tick, and every fault of file and columns."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from master.errors import ConfigError, expected
from master.fmi.description import Kind
from master.fmi.unit_names import unit as unit_named
from master.fmi.units import Conversion, Unit, conversion
from master.text.signal_name import SignalName

from .config import LoadedConfig, MeasuredColumn
from .graph import Instance, System
from .grid import Grid

if TYPE_CHECKING:
    from .input_reader import Floats


@dataclass(frozen=True)
class Feed:
    """One input under a recording; `source` names file and column, `age` counts ticks from it to its use."""

    source: str
    target: str
    age: int = 0


@dataclass(frozen=True)
class MeasuredInputs:
    """
    All inputs under recordings.

    `values` has a row for each tick and one more, shape (ticks + 1, inputs), in the units of the inputs: row
    k holds what a step to t_k uses, the value at t_k or at the start of the step, row 0 the first value.
    `files` are the recordings on disk by the names that the system has for them.
    """

    feeds: tuple[Feed, ...] = ()
    values: Floats | None = None
    files: Mapping[str, Path] = field(default_factory=dict)

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

    from .input_reader import InputReader, converted, later

    problems: list[str] = []
    feeds: list[Feed] = []
    values: list[Floats] = []
    files: dict[str, Path] = {}
    for i, given in enumerate(loaded.config.inputs):
        reader = InputReader(loaded, i, given, grid, problems)
        files[given.file] = reader.path
        for signal, column in given.map.items():
            where = loaded.where("inputs", i, "map", signal)
            targets = _targets(system, signal, where, problems)
            if targets is None:
                continue
            _refuse_second_sources(loaded, system, targets, where, problems, {f.target for f in feeds})
            into = _conversion(column, system.primary(signal).variable.unit, where, problems)
            found = reader.column(column, loaded.where("inputs", i, "map", signal, "column"))
            if into is None or found is None:
                continue
            for target, on_the_way in targets.items():
                age = _age(system, target) if given.at == "start" else 0
                feeds.append(Feed(f"{given.file}: {column.column}", target, age))
                values.append(later(age, converted(on_the_way, into.factor * found + into.offset)))
    if problems:
        raise ConfigError(dict.fromkeys(problems))
    return MeasuredInputs(tuple(feeds), np.column_stack(values), files) if feeds else MeasuredInputs()


def with_first_values(system: System, inputs: MeasuredInputs) -> System:
    """Let each input under a recording begin with its first value."""
    if inputs.values is None:
        return system
    instances: dict[str, Instance] = dict(system.instances)
    held = dict(system.held)
    for feed, value in zip(inputs.feeds, inputs.values[0], strict=True):
        name, _, variable = feed.target.partition(".")
        if name in system.connectors:
            held[feed.target] = float(value)
            continue
        start = {**instances[name].start, variable: float(value)}
        instances[name] = replace(instances[name], start=start)
    return replace(system, instances=instances, held=held)


def _targets(system: System, signal: str, where: str, problems: list[str]) -> dict[str, Conversion] | None:
    """Inputs that a signal is or leads to, with what becomes of its value; None, with a problem, if none."""
    name, variable = SignalName(signal).parts
    descriptions = {**{n: i.description for n, i in system.instances.items()}, **system.connectors}
    if name not in descriptions:
        problems.append(f"{where}: no such FMU, got {name!r}, {expected(name, descriptions)}")
        return None
    known = descriptions[name].variables
    inputs = [v.name for v in known if v.causality == "input" and v.kind is not Kind.STRING]
    if variable not in inputs:
        problems.append(f"{where}: no such input, got {variable!r}, {expected(variable, inputs)}")
        return None
    if name not in system.connectors:
        return {signal: Conversion()}
    targets = {wire.target.name: wire.conversion for wire in system.driven_by(signal)}
    if not targets:
        problems.append(f"{where}: leads to no FMU, got {signal!r}, expected a connected input")
        return None
    return targets


def _age(system: System, target: str) -> int:
    """Ticks from the start of a step to its end; none for an output of the whole system, which is read."""
    instance = system.instances.get(SignalName(target).parts[0])
    return 0 if instance is None else instance.every


def _refuse_second_sources(
    loaded: LoadedConfig,
    system: System,
    targets: Collection[str],
    where: str,
    problems: list[str],
    fed: Collection[str],
) -> None:
    wired = {w.target.name for w in system.wires}
    named = {signal for event in loaded.config.events for signal in event.set}
    set_by_events = named | {w.target.name for signal in named for w in system.driven_by(signal)}
    for target in targets:
        if target in fed or target in wired:
            problems.append(
                f"{where}: has two sources, got {target!r} again, expected one wire or one column"
            )
        elif target in set_by_events:
            problems.append(f"{where}: an event sets {target!r} too, expected one of both")


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
