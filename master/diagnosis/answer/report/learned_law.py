"""The learned law along the recordings: what it adds, over the two signals that it depends on."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fmu_sources.effects.framework.effect import Effect
from fmu_sources.effects.framework.roles import Signals
from fmu_sources.framework.arithmetic import PYTHON
from fmu_sources.framework.array_arithmetic import ARRAYS
from master.diagnosis.judge.part_result import PartResult
from master.diagnosis.numerics.arrays import Array

from .drawing import new_figure, role_label

MOST_POINTS = 4000
SHOWN = {"sign": "velocity", "plays": "position", "cycle": "time"}


def law(part: PartResult) -> Figure:
    """Draw what the last effect adds over each of its signals; the other one is the colour."""
    added, system = part.chosen.effects[-1], part.study.system
    values, signals = along(part)
    first, second = (SHOWN.get(n, n) for n in added.effect.removeprefix("learned_").split("_"))
    every = max(1, len(values) // MOST_POINTS)
    unit = system.slots(added.fmu)[added.slot].unit
    figure = new_figure(4.0)
    axes: Any = figure.subplots(1, 2, sharey=True)
    for ax, over, colour in ((axes[0], first, second), (axes[1], second, first)):
        points = ax.scatter(
            signals[over][::every], values[::every], c=signals[colour][::every], s=5, cmap="viridis"
        )
        figure.colorbar(points, ax=ax, label=_label(part, colour))
        ax.set_xlabel(_label(part, over))
        ax.xaxis.set_major_locator(MaxNLocator(5))
        ax.grid(alpha=0.3)
    axes[0].set_ylabel(f"added to {added.slot} [{unit}]")
    return figure


def along(part: PartResult) -> tuple[Array, dict[str, Array]]:
    """What the last effect adds at every sample of the recordings, and the slot's signals there."""
    added, study = part.chosen.effects[-1], part.study
    begin = f"{added.fmu}.{added.prefix}_"
    given = dict(part.chosen.fixed) | dict(part.fit.values)
    p = SimpleNamespace(**{v.name: given.get(begin + v.name, v.start) for v in added.law.parameters})
    signals = dict(study.signals[f"{added.fmu}.{added.slot}"])
    signals["time"] = study.bench.times
    values = replayed(added.law, p, signals) if added.law.states else at_once(added.law, p, signals)
    signals["memory"] = np.gradient(signals[_remembered(added.law)]) / study.bench.period
    return values, signals


def _remembered(law: Effect) -> str:
    """Role that the lagged state of a law follows."""
    return next((v.unit.strip("{}") for v in law.states if v.name == "lagged"), "value")


def _label(part: PartResult, role: str) -> str:
    """Name a signal with its unit; a memory is seen as the rate of what it remembers."""
    added, system = part.chosen.effects[-1], part.study.system
    slot = f"{added.fmu}.{added.slot}"
    if role != "memory":
        return role_label(system, slot, role)
    return f"rate of {role_label(system, slot, _remembered(added.law))[:-1]}/s]"


def at_once(law: Effect, p: Any, signals: dict[str, Array]) -> Array:
    """What a law without states adds, shape (n,); signals by role and `time`, shape (n,) each."""
    s = Signals(*(signals.get(role) for role in Signals._fields))
    found = law.law(signals["time"], signals["value"], s, SimpleNamespace(), p, ARRAYS)
    return np.asarray(found.value - signals["value"], dtype=float)


def replayed(law: Effect, p: Any, signals: dict[str, Array]) -> Array:
    """The same for a law with states, by Euler's rule: the picture needs no more."""
    t, n = signals["time"], len(signals["time"])
    roles = [signals.get(role) for role in Signals._fields]
    found, x = np.empty(n), SimpleNamespace()
    for k in range(n):
        value, s = float(signals["value"][k]), Signals(*(None if r is None else float(r[k]) for r in roles))
        if k == 0 or t[k] <= t[k - 1]:
            x = SimpleNamespace(**{v.name: value if v.name in law.follows else 0.0 for v in law.states})
        applied = law.law(float(t[k]), value, s, x, p, PYTHON)
        found[k] = applied.value - value
        period = t[k + 1] - t[k] if k + 1 < n else 0.0
        for name, change in applied.changes.items():
            setattr(x, name, getattr(x, name) + max(period, 0.0) * change)
    return found
