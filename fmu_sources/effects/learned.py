"""
A smooth law without a name: a map over a slot's signals, learned from a residual.

    y = value + sum_i B_i(a) (c_i + d_i b / b_0)

| a | B_i |
|---|---|
| position, velocity, value, load, time | 21 cubic B-splines of a/a_0 on equal knots that sum to 1 in -1..1 |
| cycle | 1 and cos, sin of the first three harmonics of a period a_0 [s] |
| plays | 10 play operators of the position, half widths w_i from 0.02 a_0 to a_0, each over its w_i |

b is position, velocity, value, `sign` of the velocity (rounded over b_0), or `memory`: the value minus its
lagged self, der(z) = (value - z)/T, which is T times its rate. The second factor of `plays` is their own
sign instead: c_i is for elongation, d_i for compression. `time` counts from the middle of its range. A signal
beyond its range is held at its end.

Parameters c_i, d_i [{value}], a_0, b_0 the half ranges, T [s] the memory
Source     de Boor, A Practical Guide to Splines (2001), Chs. IX, XVII; Krasnosel'skii, Pokrovskii, Systems
           with Hysteresis (1989), Sec. 2 (play).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import Variable, parameter, state
from .framework.effect import EVERYWHERE, MECHANICAL, Applied, Effect, Law, Rms
from .framework.shapes import clip, smooth_sign

N_SPLINES, N_HARMONICS, N_PLAYS = 21, 3, 10
SPACING = 2.0 / (N_SPLINES - 3)
CENTRES = tuple((i - (N_SPLINES - 1) / 2) * SPACING for i in range(N_SPLINES))
WIDTHS = tuple(0.02 ** (1.0 - i / (N_PLAYS - 1)) for i in range(N_PLAYS))
CORNER = 0.05
RANGE_OVER_RMS, SIGN_OVER_RMS, MEMORY_TIME = 2.5, 0.03, 5e-3
FIRST = ("position", "velocity", "value", "load", "time", "cycle", "plays")
SECOND = ("position", "velocity", "value", "sign", "memory")
_UNITS = {
    **{"position": "{position}", "velocity": "{position}/s", "value": "{value}", "load": "{load}"},
    **{"time": "s", "cycle": "s", "plays": "{position}", "sign": "{position}/s", "memory": "{value}"},
}
_NEEDS = {"position": "position", "velocity": "velocity", "load": "load", "sign": "velocity"}


def n_terms(first: str) -> int:
    """Number of functions B_i."""
    return {"cycle": 1 + 2 * N_HARMONICS, "plays": N_PLAYS}.get(first, N_SPLINES)


def coefficients(first: str) -> tuple[str, ...]:
    """Names of all c_i, then all d_i."""
    return tuple(f"{letter}_{i + 1}" for letter in "cd" for i in range(n_terms(first)))


def splines(share: Any, m: Arithmetic) -> list[Any]:
    """Values of all B-splines at a signal over its half range."""
    inside = clip(share, -1.0, 1.0, m)
    return [_cubic(m.fabs(inside - centre) / SPACING, m) for centre in CENTRES]


def harmonics(t: Any, period: Any, m: Arithmetic) -> list[Any]:
    """1 and cos, sin of the harmonics of a period [s] at t [s]."""
    angles = [2.0 * m.pi * n * t / period for n in range(1, N_HARMONICS + 1)]
    return [1.0 + 0.0 * t, *(f(angle) for angle in angles for f in (m.cos, m.sin))]


def terms(first: str, second: str, t: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> list[Any]:
    """
    What the coefficients, in the order of `coefficients`, are factors of.

    Args:
        first: Axis of the functions.
        second: Axis of their second factor.
        t: Time [s].
        s: Signals of the slot by role, and `value`.
        x: States `lagged` and `play_i`.
        p: `half_range_a`, `half_range_b`.
        m: Arithmetic.
    """
    if first == "plays":
        shares = [getattr(x, n) / (w * p.half_range_a) for n, w in zip(_PLAYS, WIDTHS, strict=True)]
        out = [m.where(share > 0.0, share, 0.0) for share in shares]
        return [*out, *(share - positive for share, positive in zip(shares, out, strict=True))]
    if first == "cycle":
        rows = harmonics(t, p.half_range_a, m)
    else:
        signal = t - p.half_range_a if first == "time" else getattr(s, first)
        rows = splines(signal / p.half_range_a, m)
    factor = _second(second, s, x, p, m)
    return [*rows, *(row * factor for row in rows)]


def _second(second: str, s: Any, x: Any, p: Any, m: Arithmetic) -> Any:
    if second == "sign":
        return smooth_sign(s.velocity, p.half_range_b, m)
    signal = s.value - x.lagged if second == "memory" else getattr(s, second)
    return clip(signal / p.half_range_b, -2.0, 2.0, m)


def _cubic(a: Any, m: Arithmetic) -> Any:
    rest = 2.0 - a
    near = 2.0 / 3.0 - a * a + 0.5 * a * a * a
    return m.where(a < 1.0, near, m.where(a < 2.0, rest * rest * rest / 6.0, 0.0))


def play_rate(velocity: Any, play: Any, width: Any, m: Arithmetic) -> Any:
    """Rate of a play operator: the velocity inside +- width, 0 where it is carried along."""
    left = width - m.where(velocity > 0.0, play, -play)
    return velocity * clip(left / (CORNER * width), 0.0, 1.0, m)


_PLAYS = tuple(f"play_{i + 1}" for i in range(N_PLAYS))


def learned(first: str, second: str) -> Effect:
    """Make the effect for one of `FIRST` and one of `SECOND`; its name says which."""
    used = {_NEEDS[a] for a in (first, second) if a in _NEEDS}
    needs = tuple(sorted(used | ({"position", "velocity"} if first == "plays" else set())))
    return Effect(
        name=f"learned_{first}_{second}",
        description=f"Undeclared smooth law over {first} and {second}",
        law=_law(first, second),
        parameters=_parameters(first, second),
        states=_states(first, second),
        absent=dict.fromkeys(coefficients(first), 0.0),
        scale=lambda rms: _scale(first, second, rms),
        needs=needs,
        places=MECHANICAL if needs else EVERYWHERE,
        held=("half_range_a", "half_range_b", *(("memory_time",) if second == "memory" else ())),
        follows=("lagged",) if second == "memory" else (),
    )


class _Seen:
    """Signals of a slot with what stands in it."""

    def __init__(self, value: Any, s: Any) -> None:
        self.value = value
        self.position, self.velocity, self.load = s.position, s.velocity, s.load


def _law(first: str, second: str) -> Law:
    names = coefficients(first)

    def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
        own = terms(first, second, t, _Seen(value, s), x, p, m)
        added = 0.0
        for name, term in zip(names, own, strict=True):
            added = added + getattr(p, name) * term
        return Applied(value + added, _changes(first, second, value, s, x, p, m))

    return law


def _changes(first: str, second: str, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> dict[str, Any]:
    found = {}
    if second == "memory":
        found["lagged"] = (value - x.lagged) / p.memory_time
    if first == "plays":
        for name, w in zip(_PLAYS, WIDTHS, strict=True):
            found[name] = play_rate(s.velocity, getattr(x, name), w * p.half_range_a, m)
    return found


def _states(first: str, second: str) -> tuple[Variable, ...]:
    plays = [state(n, "{position}", f"Play operator {n[5:]}") for n in _PLAYS if first == "plays"]
    lagged = [state("lagged", "{value}", "Lagged value z")] if second == "memory" else []
    return (*plays, *lagged)


def _parameters(first: str, second: str) -> tuple[Variable, ...]:
    own = tuple(parameter(n, 0.0, "{value}", f"Coefficient {n}") for n in coefficients(first))
    ranges = (
        parameter("half_range_a", 1.0, _UNITS[first], f"Half range of the {first} a_0", above=0.0),
        parameter("half_range_b", 1.0, _UNITS[second], f"Half range of the {second} b_0", above=0.0),
    )
    time = parameter("memory_time", MEMORY_TIME, "s", "Time constant of the memory T", above=0.0)
    return own + ranges + ((time,) if second == "memory" else ())


def _scale(first: str, second: str, rms: Rms) -> dict[str, float]:
    size = {role: RANGE_OVER_RMS * getattr(rms, role) for role in ("position", "velocity", "value", "load")}
    size |= {"time": 0.5 * rms.duration, "cycle": 1.0, "plays": size["position"], "memory": size["value"]}
    size["sign"] = SIGN_OVER_RMS * rms.velocity
    return dict.fromkeys(coefficients(first), 0.05 * rms.value) | {
        "half_range_a": size[first],
        "half_range_b": size[second],
        "memory_time": MEMORY_TIME,
    }


def axes(name: str) -> Sequence[str]:
    """First and second axis of a learned law's name."""
    return name.removeprefix("learned_").split("_")
