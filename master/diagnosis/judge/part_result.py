"""What the study of one part ends with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from master.diagnosis.numerics.arrays import Array, Mask
from master.diagnosis.numerics.drift import Drift
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.numerics.whiteness import Correlation
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.rounds import SearchResult
from master.diagnosis.search.study import Study
from master.diagnosis.unnamed_law.learn import LearnedLaw

from .channel_faults import ChannelFault
from .software_fault import SoftwareFault
from .stages import Stage


@dataclass(frozen=True)
class WithoutEffect:
    """A model that lacks one of several effects, fitted on the same rows."""

    model: ExtendedModel
    fit: Fit


@dataclass(frozen=True)
class PartResult:
    """
    One part: its base, the search for what it lacks, and what is left.

    `nominal` is the prediction with the values of the system, shape (rows, outputs). `chosen` and `fit` are
    the model with effects, also where they are not named; `is_named` says whether the effects carry their
    names. `is_exact`: the replay gives the measurement but for rounding. `unknown` says why nothing can be
    told of the part. `changed_rows`: inputs that are taken from another row than the FMU's description
    leads to, with that row. `stages` judge the refit and each model after it. `objections` say by effect what
    forbids to call it traced. `unknown_numbers` and `unknown_when_refitted` say by parameter, of the last
    model and of the refit, why it has no number. `without` holds, by effect, the model that lacks it alone,
    fitted again.
    """

    study: Study
    nominal: Array
    base: Fit
    chosen: ExtendedModel
    fit: Fit
    is_exact: bool = False
    unknown: str = ""
    is_named: bool = True
    has_remainder: bool = False
    search: SearchResult | None = None
    learned: LearnedLaw | None = None
    stages: tuple[Stage, ...] = ()
    software_fault: SoftwareFault | None = None
    objections: Mapping[str, str] = field(default_factory=dict)
    unknown_numbers: Mapping[str, str] = field(default_factory=dict)
    unknown_when_refitted: Mapping[str, str] = field(default_factory=dict)
    channel_faults: tuple[ChannelFault, ...] = ()
    without: Mapping[str, WithoutEffect] = field(default_factory=dict)
    correlations: tuple[Correlation, ...] = ()
    whiteness: float = 1.0
    drifts: tuple[Drift, ...] = ()
    moved: Mapping[str, float] = field(default_factory=dict)
    parameter_gain: bool = False
    changed_rows: Mapping[str, str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the part."""
        return self.study.name

    @property
    def outputs(self) -> list[str]:
        """Compared outputs, as `instance.variable`."""
        return self.study.bench.outputs

    @property
    def measured(self) -> Array:
        """What was measured of them, shape (rows, outputs)."""
        return self.study.measured

    @property
    def in_use(self) -> Mask:
        """Rows that are compared: the replay has settled, shape (rows,)."""
        return self.study.bench.in_use

    @property
    def row_period(self) -> float:
        """Time between compared rows [s]."""
        return self.study.bench.row_period

    @property
    def fmus(self) -> list[str]:
        """FMUs that the effects are in, the first effect's first."""
        return list(dict.fromkeys(e.fmu for e in self.chosen.effects))

    @property
    def values(self) -> dict[str, float]:
        """Values of the model with effects by `fmu.variable`: what is fixed, and what was fitted."""
        return dict(self.chosen.fixed) | dict(self.fit.values)

    @property
    def has_effect(self) -> bool:
        """Whether an effect is claimed, with a name or without."""
        return bool(self.chosen.effects)

    @property
    def is_judged(self) -> bool:
        """Whether something may be said of what is left: it is no rounding, and its inputs are known."""
        return not self.is_exact and not self.unknown

    @property
    def final(self) -> Stage:
        """The last stage."""
        return self.stages[-1]

    @property
    def families(self) -> list[tuple[str, ...]]:
        """Effects that are indistinguishable."""
        return self.search.families if self.search is not None and self.is_named else []
