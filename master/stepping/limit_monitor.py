"""Limits of a run: which signals have to stay within which magnitude, and what is said where one does not."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from master.fmi.description import Kind
from master.fmi.value_types import LONG, MOST_EXACT
from master.system.graph import Port, System
from master.system.grid import Grid

from .machine.interpreter import LARGEST, LimitMonitor
from .machine.program import Floats, Integers, Program


def make_limit_monitor(
    program: Program,
    ports: Sequence[Port],
    limits: Mapping[str, float],
    used: Collection[str],
    triggers: Integers,
    thresholds: Floats,
) -> LimitMonitor:
    """
    Watch recorded signals.

    Args:
        program: The program.
        ports: Recorded signals.
        limits: Largest magnitude by signal; the others have to be finite.
        used: Signals that end the run where they are beyond; of the others a warning is kept.
        triggers: See `LimitMonitor`.
        thresholds: See `LimitMonitor`.
    """
    names = [p.name for p in ports]
    bounds = [largest_magnitude(p, limits) for p in ports]
    ends = [ends_a_run(p, limits, used) for p in ports]
    return LimitMonitor(
        record=np.array([program.place[n] for n in names], dtype=np.int64),
        limits=np.array(bounds, dtype=np.float64),
        used=np.array(ends, dtype=np.int64),
        first_beyond=np.full(len(names), -1, dtype=np.int64),
        triggers=triggers,
        thresholds=thresholds,
    )


def largest_magnitude(port: Port, limits: Mapping[str, float]) -> float:
    """Return the largest magnitude that a recorded signal may have."""
    return min(limits.get(port.name, MOST_EXACT if _may_be_rounded(port) else LARGEST), LARGEST)


def ends_a_run(port: Port, limits: Collection[str], used: Collection[str]) -> bool:
    """Whether a run ends where a recorded signal is beyond its largest magnitude."""
    return port.name in limits or (port.name in used and not _may_be_rounded(port))


def used_signals(
    system: System, limits: Collection[str], compared: Collection[str], conditions: Collection[str]
) -> set[str]:
    """Signals that somebody uses: a wire, a limit, a comparison, a condition."""
    return {w.source.name for w in system.wires} | {*limits, *compared, *conditions}


def what_is_beyond(port: Port, value: float, limit: float) -> str:
    """Say what is wrong with a signal that ended a run."""
    if not math.isfinite(value):
        what = "is not a number" if math.isnan(value) else "is infinite"
        return f"{port.name} {what}, got {value}, expected a finite value"
    unit = "" if port.variable.unit_name == "1" else f" {port.variable.unit_name}"
    return f"{port.name}: got {value:.6g}{unit}, expected a magnitude of at most {limit:.6g}{unit}"


def warnings(monitor: LimitMonitor, ports: Sequence[Port], grid: Grid) -> list[str]:
    """Say which signals that nobody uses were not finite, and which integers a double does not hold."""
    return [
        _warning(port, grid.time(tick + 1))
        for port, tick in zip(ports, monitor.first_beyond.tolist(), strict=True)
        if tick >= 0
    ]


def _warning(port: Port, time: float) -> str:
    if _may_be_rounded(port):
        return f"{port.name} reaches 2^53 from t={time:.15g} s on; the rows have it rounded to a double"
    return f"{port.name} is not finite from t={time:.15g} s on; nothing uses it"


def _may_be_rounded(port: Port) -> bool:
    """Whether a signal can have more digits than the rows."""
    return port.variable.kind is Kind.INTEGER and port.variable.value_type in LONG
