"""
One period of identification: prefilter, the recursion that identifiers share, the choice among them.

    f, s     = force after FMDC and s_act - x, prefiltered
    H        = (f(k-1), f(k-2), -s(k), -s(k-1), -s(k-2)),   Z = f(k)                             (20)
    Y, P     = the recursion with the settings of the chosen identifier, or as they are while held
    Y        = what the chosen identifier estimates by itself, if it does so

Source   Paper, Sec. IV-B.2, Eqs. 19-21; which identifiers there are: folder `identifiers`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from ..framework.arithmetic import Arithmetic
from ..framework.model import Learning, Linear
from .identifiers.framework import recursion
from .identifiers.framework.catalogue import listed
from .identifiers.framework.identifier import Identifier, Measurement, Vector
from .tuning import Tuning, low_pass, prefilter_share, tuning

LINEAR = tuple(
    Linear(
        "identifier",
        one.name,
        "identification is not linear: its process parameters are the assumed ones",
    )
    for one in listed()
    if one.held_by is None
)
LEARNING = tuple(Learning("identifier", one.name, one.held_by) for one in listed() if one.held_by)


class Identified(NamedTuple):
    """Y after a period, and the next values of all states of the identification."""

    Y: Vector
    memory: Mapping[str, Any]


def prior_gain(p: Any, m: Arithmetic, identifiers: Sequence[Identifier] = listed()) -> Any:
    """Return the factor on c, d, e at the start: 1 for identifiers that do not learn."""
    gain = p.prior_gain
    for one in identifiers:
        if one.held_by is None:
            gain = m.where(p.identifier == one.number, 1.0, gain)
    return gain


def identified(
    f_lead: Any, s: Any, x: Any, p: Any, m: Arithmetic, identifiers: Sequence[Identifier] = listed()
) -> Identified:
    """
    Step the identification by one period.

    Args:
        f_lead: Force after FMDC [N].
        s: s_act - x [m].
        x: States of the compensator.
        p: Its parameters.
        m: Arithmetic.
        identifiers: All that the parameter `identifier` chooses from.
    """
    chosen = tuning(p, m)
    share = prefilter_share(chosen.prefilter_frequency, p.sample_time, m)
    f_stage, f = low_pass(x.f_stage, x.f_1, f_lead, share)
    s_stage, s = low_pass(x.s_stage, x.s_1, s, share)
    known = Measurement((x.f_1, x.f_2, -s, -x.s_1, -x.s_2), f, (x.a, x.b, x.c, x.d, x.e))
    Y, P = _recursion(known, [one for one in identifiers if one.settings], chosen, x, p, m)
    states: dict[str, Any] = {}
    for one in identifiers:
        if one.estimate is not None:
            is_chosen = p.identifier == one.number
            held = _held(one, p)
            own = one.estimate(known, x, p, m)
            Y = _each(m, is_chosen, _each(m, held, known.Y, own.Y), Y)
            for name, new in own.states.items():
                old = getattr(x, name)
                states[name] = _one_or_each(m, is_chosen, _one_or_each(m, held, old, new), old)
    memory = {"f_stage": f_stage, "f_1": f, "f_2": x.f_1, "s_stage": s_stage, "s_1": s, "s_2": x.s_1, "P": P}
    return Identified(Y, memory | states)


def _recursion(
    known: Measurement, sharing: Sequence[Identifier], chosen: Tuning, x: Any, p: Any, m: Arithmetic
) -> tuple[Vector, Vector]:
    """Return Y and P after the measurement, with the settings of the one that is chosen."""
    first, *others = sharing
    use = _settings(first, chosen, x, p, m)
    held = _held(first, p)
    for one in others:
        is_it = p.identifier == one.number
        use = recursion.Settings(*_each(m, is_it, _settings(one, chosen, x, p, m), use))
        if one.held_by != first.held_by:
            held = m.where(is_it, _held(one, p), held)
    P = recursion.predicted(recursion.inflated(x.P, use.inflation), use.Q_ab, use.Q_cde)
    Y, P = recursion.corrected(known.Y, P, known.H, known.Z, use.R, m)
    return _each(m, held, known.Y, Y), _each(m, held, x.P, P)


def _held(one: Identifier, p: Any) -> Any:
    return False if one.held_by is None else getattr(p, one.held_by)


def _settings(one: Identifier, chosen: Tuning, x: Any, p: Any, m: Arithmetic) -> recursion.Settings:
    assert one.settings is not None
    return one.settings(x.P, chosen, p, m)


def _each(m: Arithmetic, condition: Any, yes: Sequence[Any], no: Sequence[Any]) -> Vector:
    return tuple(m.where(condition, one, other) for one, other in zip(yes, no, strict=True))


def _one_or_each(m: Arithmetic, condition: Any, yes: Any, no: Any) -> Any:
    return _each(m, condition, yes, no) if isinstance(yes, tuple) else m.where(condition, yes, no)
