"""What may be claimed: a status for each effect, and one verdict for the whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from fmu_sources.effects.catalogue import listed
from fmu_sources.effects.framework.common import SMOOTHING
from master.diagnosis.adequacy.channels import Adequacy, Kind, Predictor
from master.diagnosis.judge.diagnose import Diagnosis
from master.diagnosis.judge.part_result import PartResult
from master.diagnosis.numerics.deviations import NORMAL
from master.diagnosis.replay.placed_effect import PlacedEffect

from .before_after import SealedPart

SAME_LINE = 0.05  # relative difference of two frequencies that are one
NEAR_BEST = 0.8  # of the best share: a law of a slot that predicts as much


class Verdict(Enum):
    """The answer in a few words."""

    NOTHING = "nothing missing"
    PARAMETERS = "parameters only"
    TRACED = "traced"
    PARTLY = "partly, with a remainder"
    ONE_OF_A_CLASS = "one of a class"
    UNDECLARED = "undeclared"
    NOT_CONFIRMED = "not confirmed on the sealed part"
    UNEXPLAINED = "unexplained, not predictable"
    SOFTWARE = "fault of a software part"


class Status(Enum):
    """What is known of one effect."""

    TRACED = "traced"
    ONE_OF_A_CLASS = "one of a class"
    NEAREST = "nearest name"
    NOT_CONFIRMED = "not confirmed"
    LEARNED = "undeclared"


@dataclass(frozen=True)
class Claim:
    """An effect with its status and, in a sentence, why it is not more."""

    placed: PlacedEffect
    status: Status
    why: str = ""


def claims(part: PartResult, sealed: SealedPart) -> list[Claim]:
    """Status of each effect of a part."""
    return [_claim(part, sealed, e) for e in part.chosen.effects]


def _claim(part: PartResult, sealed: SealedPart, placed: PlacedEffect) -> Claim:
    gain = sealed.gains.get(str(placed))
    if not sealed.is_confirmed or gain is None or gain.interval.low <= 0.0:
        return Claim(placed, Status.NOT_CONFIRMED, "its gain on the sealed part is within chance")
    if placed.effect not in listed():
        return Claim(placed, Status.LEARNED)
    if not part.is_named:
        return Claim(placed, Status.NEAREST, "found beside a law without a name, which may hide others")
    if str(placed) in part.objections:
        return Claim(placed, Status.NEAREST, part.objections[str(placed)])
    own = [p.name for p in part.chosen.parameters if placed.owns(p.name)]
    free = [name for name in own if placed.short_name(name) != SMOOTHING]
    if free and not any(_is_known(part, name) for name in free):
        return Claim(placed, Status.NEAREST, "none of its parameters is known to differ from zero")
    vague = next((c for c in part.final.channels if _is_vague(c)), None)
    if vague is not None:
        why = f"what is left in {vague.signal} is no noise, and nothing recorded says what it is"
        return Claim(placed, Status.NEAREST, why)
    if any(str(placed) in family for family in part.families):
        return Claim(placed, Status.ONE_OF_A_CLASS, "other members of its class explain it equally well")
    rest = _same_shape(part, placed)
    if rest is not None:
        return Claim(placed, Status.NEAREST, f"what is left follows {rest}")
    return Claim(placed, Status.TRACED)


def _is_known(part: PartResult, name: str) -> bool:
    """Whether a fitted parameter has a number, and its 95 % interval does not hold zero."""
    half = NORMAL * part.fit.deviations.get(name, 0.0)
    return name not in part.unknown_numbers and abs(part.values[name]) > half


def _is_vague(channel: Adequacy) -> bool:
    """Whether what is left is no noise, and nothing tells that it is of another law than the one named."""
    is_elsewhere = channel.is_predictable or channel.events or channel.strikes
    return channel.is_uneven and not is_elsewhere


def _same_shape(part: PartResult, placed: PlacedEffect) -> Predictor | None:
    """What still predicts the residual by the signals of an effect, in its own slot."""
    if part.final.is_adequate:
        return None
    own = set(placed.law.needs) or {"value"}
    for channel in part.final.channels:
        if not channel.is_predictable:
            continue
        for p in channel.predictors:
            if p.share.value < NEAR_BEST * channel.share.value:
                break
            if p.law is not None and p.law.place == placed.place and set(p.law.roles) & own:
                return p
            if p.kind is Kind.MODULATED and _swings_at(part, placed, p.frequency):
                return p
    return None


def _swings_at(part: PartResult, placed: PlacedEffect, frequency: float) -> bool:
    """Whether an effect swings in time at a frequency [Hz]: what is left at it is of the same cause."""
    own = (placed.variable(v.name) for v in placed.law.parameters if v.unit == "Hz")
    return any(abs(part.values.get(name, 0.0) - frequency) < SAME_LINE * frequency for name in own)


def verdict(diagnosis: Diagnosis, sealed: Mapping[str, SealedPart]) -> Verdict:
    """One verdict for all parts of a case."""
    parts = diagnosis.parts
    if any(p.software_fault is not None for p in parts):
        return Verdict.SOFTWARE
    found = [c.status for p in parts for c in claims(p, sealed[p.name])]
    is_adequate = all(not p.is_judged or p.final.is_adequate for p in parts)
    sure = {Status.TRACED, Status.ONE_OF_A_CLASS}
    if found:
        if sure & set(found):
            if not is_adequate or {Status.NEAREST, Status.LEARNED, Status.NOT_CONFIRMED} & set(found):
                return Verdict.PARTLY
            return Verdict.ONE_OF_A_CLASS if Status.ONE_OF_A_CLASS in found else Verdict.TRACED
        if all(s is Status.NOT_CONFIRMED for s in found):
            return Verdict.NOT_CONFIRMED
        return Verdict.UNDECLARED
    if any(p.is_judged and p.final.is_predictable for p in parts):
        return Verdict.UNDECLARED
    if not is_adequate:
        return Verdict.UNEXPLAINED
    pays = (p.parameter_gain and not sealed[p.name].is_refit_worse for p in parts)
    return Verdict.PARAMETERS if any(pays) else Verdict.NOTHING


def shape(channel: Adequacy) -> str:
    """What a residual is like: what predicts it, where, and how much of it is left."""
    left = f"{channel.ratio:.3g} times the noise floor in {channel.signal}"
    if not channel.is_predictable:
        kind = channel.colour.words
        if channel.is_uneven:
            kind = f"{kind}, but no noise: its size differs from time to time"
        if channel.strikes:
            kind = f"intermittent: it is set off around {_times(channel.strikes)}, and rings on"
        if channel.events:
            kind = f"intermittent, around {_times(channel.events)}"
        return f"{left}; it does not follow from anything recorded; it is {kind}"
    best = channel.best
    assert best is not None
    near = [
        p
        for p in channel.predictors[1:]
        if p.share.value > NEAR_BEST * best.share.value and p.law is not None
    ]
    also = f", about as well as {near[0]}" if near and best.law is not None else ""
    told = f"{100.0 * best.share.value:.0f} % of it follow {describe(best)}{also}"
    if best.law is None and best.kind in (Kind.TREES, Kind.LINEAR) and near:
        told += f"; of the laws of one slot, {near[0].law} comes nearest"
    if channel.events:
        told += f"; most of it is around {_times(channel.events)}"
    elif channel.strikes:
        told += f"; it is set off around {_times(channel.strikes)}"
    return f"{left}; {told}"


def describe(p: Predictor) -> str:
    """A predictor in words."""
    return str(p)


def _times(events: tuple[float, ...]) -> str:
    shown = ", ".join(f"{t:.2f}" for t in events[:6])
    return f"t = {shown} s" + (f" and {len(events) - 6} more" if len(events) > 6 else "")
