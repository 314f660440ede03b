"""A claim of the paper as data: inequalities over runs and what they follow from; and how it is judged."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from master.reproduce.measures.measures import MEANINGS, NOISELESS
from master.reproduce.measures.runs import Recording, Run, Wanted

HOLDS, CONDITION, FAILS = "holds", "holds with a condition", "does not hold"
SEEDS = tuple(range(1, 11))


@dataclass(frozen=True)
class Bound:
    """Open interval of the values that agree with a claim."""

    low: float = -math.inf
    high: float = math.inf

    def holds(self, value: float) -> bool:
        """Whether the value is inside; NaN is not."""
        return self.low < value < self.high

    def margin(self, value: float) -> float:
        """Distance to the nearer end, negative outside."""
        return min(value - self.low, self.high - value) if value == value else -math.inf

    def text(self, name: str, unit: str = "") -> str:
        """Inequality for people."""
        if self.low == -self.high and math.isfinite(self.high):
            return f"|{name}| < {self.high:.4g}" + f" {unit}" * bool(unit)
        low, high = (f"{end:.4g}" + f" {unit}" * bool(unit) for end in (self.low, self.high))
        if math.isfinite(self.low) and math.isfinite(self.high):
            return f"{self.low:.4g} < {name} < {high}"
        return f"{name} > {low}" if math.isfinite(self.low) else f"{name} < {high}"


def above(low: float) -> Bound:
    """Larger than low."""
    return Bound(low=low)


def below(high: float) -> Bound:
    """Smaller than high."""
    return Bound(high=high)


def around(middle: float, half_width: float) -> Bound:
    """Not farther from the middle than the half width."""
    return Bound(middle - half_width, middle + half_width)


def first(*values: float) -> float:
    """Take the number of the first run."""
    return values[0]


@dataclass(frozen=True)
class Check:
    """
    One row: a number from runs that differ in the noise only, and its bound.

    `combine` makes one number of those of the runs, which `name` names. `why` and `claim` take precedence
    over those of the claim; `expected` is the verdict found when it was written, if not that of the claim.
    `bound_from` is what the bound follows from other than from the measured value.
    """

    id: str
    case: str
    measure: str
    runs: tuple[Run, ...]
    bound: Bound
    unit: str = ""
    combine: Callable[..., float] = first
    expected: str | None = None
    why: str = ""
    claim: str = ""
    name: str = ""
    bound_from: str = ""


@dataclass(frozen=True)
class Claim:
    """
    What the paper says, where, and the checks that judge it.

    `if_met` is the verdict if a bound is met; `bound_from` is used where a check has none of its own.
    """

    id: str
    place: str
    claim: str
    why: str
    checks: tuple[Check, ...]
    if_met: str = HOLDS
    bound_from: str = ""


@dataclass(frozen=True)
class Row:
    """A judged check; the fields are the keys of `--json`. `noise` says what the noise does to the value."""

    id: str
    place: str
    claim: str
    bound: str
    bound_from: str
    measured: float | None
    seeds: int
    noise: str
    verdict: str
    why: str

    def as_dict(self) -> dict[str, Any]:
        """Fields for JSON."""
        return dict(vars(self))


def wishes(claims: Sequence[Claim]) -> dict[Run, Wanted]:
    """Return the runs of all checks, every seed, with the numbers they are asked for."""
    found: dict[Run, Wanted] = {}
    for check in (c for claim in claims for c in claim.checks):
        for run in (r.with_seed(seed) for r in check.runs for seed in SEEDS):
            found[run] = found.get(run, Wanted()) | Wanted(measures=frozenset({check.measure}))
    return found


def judge(claim: Claim, recordings: Mapping[Run, Recording]) -> list[Row]:
    """Judge each check by its worst seed."""
    return [_row(claim, check, _worst(check, recordings)) for check in claim.checks]


def changed_verdicts(claim: Claim, rows: Sequence[Row]) -> list[str]:
    """Name the rows whose verdict is another one than when the claim was written."""
    return [
        f"{row.id}: {row.verdict}, expected {expected}"
        for row, check in zip(rows, claim.checks, strict=True)
        if row.verdict != (expected := check.expected or claim.if_met)
    ]


def _worst(check: Check, recordings: Mapping[Run, Recording]) -> float:
    values = [_value(check, recordings, seed) for seed in SEEDS]
    return min(values, key=check.bound.margin)


def _value(check: Check, recordings: Mapping[Run, Recording], seed: int) -> float:
    numbers = [recordings[run.with_seed(seed)].numbers[check.measure] for run in check.runs]
    return float(check.combine(*numbers))


def _row(claim: Claim, check: Check, value: float) -> Row:
    return Row(
        id=f"{claim.id}.{check.id}",
        place=claim.place,
        claim=f"{check.claim or claim.claim} ({check.case})",
        bound=check.bound.text(check.name or MEANINGS[check.measure], check.unit),
        bound_from=check.bound_from or claim.bound_from,
        measured=value if math.isfinite(value) else None,
        seeds=len(SEEDS),
        noise=NOISELESS.get(check.measure, f"worst of {len(SEEDS)} seeds"),
        verdict=claim.if_met if check.bound.holds(value) else FAILS,
        why=check.why or claim.why,
    )


def overall(rows: Sequence[Row]) -> str:
    """Verdict on a claim as a whole: what all rows have; a condition where they differ."""
    found = {row.verdict for row in rows}
    return found.pop() if len(found) == 1 else CONDITION
