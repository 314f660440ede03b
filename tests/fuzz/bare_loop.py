"""A bare loop over FMPy: the oracle of random systems. It shares no code with the master."""

from __future__ import annotations

import itertools
import zipfile
from collections import deque
from pathlib import Path

from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

from .systems import N_STEPS, UNITS, Fmu, H, RandomSystem, Variable

Values = tuple[float, ...]


class Slave:
    """One FMU through FMPy: typed getters and setters by kind."""

    def __init__(self, fmu: Fmu, archive: Path, folder: Path) -> None:
        with zipfile.ZipFile(archive) as packed:
            packed.extractall(folder)
        self.is_3 = fmu.version == "3.0"
        slave = FMU3Slave if self.is_3 else FMU2Slave
        self.fmu = slave(
            guid="mixer", unzipDirectory=str(folder), modelIdentifier="mixer", instanceName=fmu.name
        )
        self.fmu.instantiate()

    def start(self) -> None:
        if not self.is_3:
            self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()

    def set(self, v: Variable, values: Values) -> None:
        kind, typed = self._kind(v), [self._typed(v, x) for x in values]
        getattr(self.fmu, f"set{kind}")([v.reference], typed)

    def get(self, v: Variable) -> Values:
        kind = self._kind(v)
        more = {"nValues": v.n} if self.is_3 else {}
        return tuple(float(x) for x in getattr(self.fmu, f"get{kind}")([v.reference], **more))

    def _kind(self, v: Variable) -> str:
        if v.kind == "Enumeration":
            return "Int64" if self.is_3 else "Integer"
        return v.kind

    def _typed(self, v: Variable, value: float) -> float | int | bool:
        if v.kind == "Boolean":
            return bool(value)
        return value if v.kind in ("Real", "Float64", "Float32") else int(value)


def step_through(system: RandomSystem, archives: dict[str, Path], folder: Path) -> dict[str, list[float]]:
    """Every output element by `instance.name`, one value a row; all names of an output are there."""
    slaves = {f.name: Slave(f, archives[f.name], folder / f.name) for f in system.fmus}
    for fmu in system.fmus:
        slaves[fmu.name].start()
        given = system.given.get(fmu.name, {})
        for v in fmu.variables:
            for name in v.names:
                if name in given:
                    slaves[fmu.name].set(v, given[name])
    lines = _connect(system, slaves)
    for slave in slaves.values():
        slave.fmu.exitInitializationMode()
    rows: dict[str, list[float]] = {}
    _record(system, slaves, rows)
    for k in range(N_STEPS):
        for group in system.order:
            _step_group(system, slaves, lines, group, k * H)
        _record(system, slaves, rows)
    for slave in slaves.values():
        slave.fmu.terminate()
        slave.fmu.freeInstance()
    return rows


def _connect(system: RandomSystem, slaves: dict[str, Slave]) -> list[deque[Values]]:
    """Hand the first outputs on; the delay line of each wire is filled with them."""
    lines = []
    for i, wire in enumerate(system.wires):
        first = _converted(system, i, slaves)
        slaves[wire.target.name].set(wire.input, first)
        lines.append(deque([first] * wire.delay))
    return lines


def _step_group(
    system: RandomSystem,
    slaves: dict[str, Slave],
    lines: list[deque[Values]],
    group: tuple[str, ...],
    t: float,
) -> None:
    """Set the inputs of all members, then step them."""
    for i, wire in enumerate(system.wires):
        if wire.target.name in group:
            lines[i].append(_converted(system, i, slaves))
            slaves[wire.target.name].set(wire.input, lines[i].popleft())
    for name in group:
        slaves[name].fmu.doStep(currentCommunicationPoint=t, communicationStepSize=H)


def _converted(system: RandomSystem, i: int, slaves: dict[str, Slave]) -> Values:
    wire = system.wires[i]
    _, factor, offset = UNITS[wire.output.unit]
    _, to_factor, to_offset = UNITS[wire.input.unit]
    values = slaves[wire.source.name].get(wire.output)
    if wire.output.unit == wire.input.unit:
        return values
    scale = factor / to_factor
    shift = (offset - to_offset) / to_factor
    return tuple(scale * x + shift for x in values)


def _record(system: RandomSystem, slaves: dict[str, Slave], rows: dict[str, list[float]]) -> None:
    for fmu in system.fmus:
        for v in fmu.having("o"):
            values = slaves[fmu.name].get(v)
            for name in v.names:
                for label, value in zip(_labels(v, name), values, strict=True):
                    rows.setdefault(f"{fmu.name}.{label}", []).append(value)


def _labels(v: Variable, name: str) -> list[str]:
    if not v.shape:
        return [name]
    indices = itertools.product(*(range(1, n + 1) for n in v.shape))
    return [f"{name}[{','.join(map(str, index))}]" for index in indices]
