"""What the study of one part ends with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.ceiling import Ceiling
from master.diagnosis.numerics.drift import Drift
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.numerics.whiteness import Correlation
from master.diagnosis.search.rounds import Found
from master.diagnosis.search.study import Extended, Study
from master.diagnosis.unnamed_law.learn import Learned


@dataclass(frozen=True)
class PartResult:
    """
    One part: its base, what was found, and what is left.

    `chosen` and `fit` are the model with effects, also where they are not named; `is_named` says whether
    the effects carry their names. `is_exact`: the replay gives the measurement but for rounding.
    """

    study: Study
    nominal: Array
    base: Fit
    chosen: Extended
    fit: Fit
    is_exact: bool = False
    is_named: bool = True
    has_remainder: bool = False
    found: Found | None = None
    learned: Learned | None = None
    ceiling: Ceiling | None = None
    ceiling_after: Ceiling | None = None
    correlations: tuple[Correlation, ...] = ()
    whiteness: float = 1.0
    drifts: tuple[Drift, ...] = ()
    moved: Mapping[str, float] = field(default_factory=dict)
    parameter_gain: bool = False

    @property
    def fmus(self) -> list[str]:
        """FMUs that the effects are in, the first effect's first."""
        return list(dict.fromkeys(a.fmu for a in self.chosen.added))

    @property
    def has_effect(self) -> bool:
        """Whether an effect is claimed, with a name or without."""
        return bool(self.chosen.added)

    @property
    def families(self) -> list[tuple[str, ...]]:
        """Effects that cannot be told apart."""
        return self.found.families if self.found is not None and self.is_named else []
