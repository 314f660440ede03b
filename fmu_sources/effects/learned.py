"""
A smooth law without a name: a map over two of the slot's signals, learned from a residual.

    y = value + sum_ij c_ij B_i(a / a_0) B_j(b / b_0)

B_1..B_7 are cubic B-splines on equal knots that sum to 1 between -1 and 1; a and b are held at the ends of
that range. a and b are two of value, position, velocity, load, `time` (from the middle of its range), and
`memory`: position (or value, where there is none) minus its lagged self, der(z) = (signal - z) / T. An odd
law has c_ij = -c_(8-i)(8-j), an even one the same sign.

Parameters c_i_j [{value}], a_0, b_0 the half ranges of the signals, T [s] the memory
Source     de Boor, A Practical Guide to Splines (2001), Chs. IX, XVII.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..arithmetic import Arithmetic
from ..variables import Variable, parameter, state
from .effect import EVERYWHERE, MECHANICAL, Applied, Effect, Law, Rms
from .shapes import clip

N_SPLINES = 7
SPACING = 2.0 / (N_SPLINES - 3)
CENTRES = tuple((i - (N_SPLINES - 1) / 2) * SPACING for i in range(N_SPLINES))
COEFFICIENTS = tuple(f"c_{i}_{j}" for i in range(1, N_SPLINES + 1) for j in range(1, N_SPLINES + 1))
RANGE_OVER_RMS = 2.0
AXES = ("value", "position", "velocity", "load", "memory", "time")
_UNITS = {
    "value": "{value}",
    "position": "{position}",
    "velocity": "{position}/s",
    "load": "{load}",
    "memory": "{position}",
    "time": "s",
}


def splines(share: Any, m: Arithmetic) -> list[Any]:
    """Values of B_1..B_7 at a signal over its half range."""
    inside = clip(share, -1.0, 1.0, m)
    return [_cubic(m.fabs(inside - centre) / SPACING, m) for centre in CENTRES]


def learned(first: str, second: str) -> Effect:
    """Make the effect for two of `AXES`; its name says which."""
    axes = (first, second)
    has_memory = "memory" in axes
    needs = tuple(sorted({a for a in axes if a in ("position", "velocity", "load")}))
    memory = "position" if "position" in needs or "velocity" in needs else "value"
    unit = _UNITS | {"memory": "{" + memory + "}"}
    return Effect(
        name=f"learned_{first}_{second}",
        description=f"Undeclared smooth law over {first} and {second}",
        law=_law(axes, memory),
        parameters=_parameters(axes, unit, has_memory),
        states=(state("lagged", unit["memory"], "Lagged signal z"),) if has_memory else (),
        absent=dict.fromkeys(COEFFICIENTS, 0.0),
        scale=lambda rms: _scale(axes, memory, rms),
        needs=(*needs, "position")
        if has_memory and memory == "position" and "position" not in needs
        else needs,
        places=MECHANICAL if needs else EVERYWHERE,
        held=("half_range_a", "half_range_b", *(("memory_time",) if has_memory else ())),
        follows=("lagged",) if has_memory and memory == "value" else (),
    )


def _cubic(a: Any, m: Arithmetic) -> Any:
    rest = 2.0 - a
    near = 2.0 / 3.0 - a * a + 0.5 * a * a * a
    return m.where(a < 1.0, near, m.where(a < 2.0, rest * rest * rest / 6.0, 0.0))


def _law(axes: Sequence[str], memory: str) -> Law:
    has_memory = "memory" in axes

    def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
        ranges = (p.half_range_a, p.half_range_b)
        signals = {"value": value, **s._asdict()}
        if "time" in axes:
            signals["time"] = t - ranges[axes.index("time")]
        changes = {}
        if has_memory:
            signals["memory"] = signals[memory] - x.lagged
            changes["lagged"] = signals["memory"] / p.memory_time
        rows = splines(signals[axes[0]] / ranges[0], m)
        columns = splines(signals[axes[1]] / ranges[1], m)
        added = 0.0
        for i, row in enumerate(rows):
            line = 0.0
            for j, column in enumerate(columns):
                line = line + getattr(p, COEFFICIENTS[i * N_SPLINES + j]) * column
            added = added + row * line
        return Applied(value + added, changes)

    return law


def _parameters(axes: Sequence[str], unit: dict[str, str], has_memory: bool) -> tuple[Variable, ...]:
    coefficients = tuple(
        parameter(name, 0.0, "{value}", "Coefficient of the splines " + name[2:].replace("_", " and "))
        for name in COEFFICIENTS
    )
    ranges = (
        parameter("half_range_a", 1.0, unit[axes[0]], f"Half range of the {axes[0]} a_0", above=0.0),
        parameter("half_range_b", 1.0, unit[axes[1]], f"Half range of the {axes[1]} b_0", above=0.0),
    )
    time = (parameter("memory_time", 0.1, "s", "Time constant of the memory T", above=0.0),)
    return coefficients + ranges + (time if has_memory else ())


def _scale(axes: Sequence[str], memory: str, rms: Rms) -> dict[str, float]:
    size = {a: getattr(rms, a) for a in AXES if a not in ("memory", "time")}
    size |= {"memory": getattr(rms, memory), "time": 0.5 * rms.duration / RANGE_OVER_RMS}
    return dict.fromkeys(COEFFICIENTS, 0.05 * rms.value) | {
        "half_range_a": RANGE_OVER_RMS * size[axes[0]],
        "half_range_b": RANGE_OVER_RMS * size[axes[1]],
        "memory_time": 0.1,
    }


EFFECT = learned("position", "velocity")
WITH_MEMORY = learned("velocity", "memory")
OF_VALUE = learned("value", "memory")
