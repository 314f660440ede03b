"""A campaign as written: which system, what varies and how, what is kept of each run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, field_validator, model_validator

from master.errors import nearest
from master.evaluation.metrics import NAMES
from master.text.fields import Finite, Integer, Name, OrEmpty, Positive, Seconds, Section, Signal
from master.text.schema import OrText
from master.text.signal_name import SignalName
from master.text.validation import validated
from master.text.yaml_lines import Document, read_yaml

Pair = tuple[Finite, Finite]
Points = tuple[Finite, Finite, Annotated[Integer, Field(ge=2, le=10**6)]]

LISTS = ("values", "linspace", "logspace")
DISTRIBUTIONS = ("uniform", "normal", "lognormal", "triangular", "integers", "choice")
LINKS = ("same_as", "expression")
KINDS = (*LISTS, *DISTRIBUTIONS, *LINKS)


class Vary(Section):
    """
    How one value varies, in one of these ways; numbers are in `unit`, else in the unit of the variable.

    `values` [v, ...]; `linspace`, `logspace` [first, last, n]; `uniform` [low, high]; `normal` [mean,
    deviation]; `lognormal` [median, deviation of the logarithm]; `triangular` [low, mode, high]; `integers`
    [low, high]; `choice` [v, ...] with `weights`. `same_as` another signal, times `factor` plus `offset`;
    `expression` of others, such as `3.96 * contact.k_p`. `bounds` truncate a distribution.
    """

    values: Annotated[list[Any], Field(min_length=1)] | None = None
    linspace: Points | None = None
    logspace: Points | None = None
    uniform: Pair | None = None
    normal: tuple[Finite, Positive] | None = None
    lognormal: tuple[Positive, Positive] | None = None
    triangular: tuple[Finite, Finite, Finite] | None = None
    integers: tuple[Integer, Integer] | None = None
    choice: Annotated[list[Any], Field(min_length=1)] | None = None
    weights: list[Positive] | None = None
    same_as: str | None = None
    factor: Finite = 1.0
    offset: Finite = 0.0
    expression: str | None = None
    unit: str | None = None
    bounds: Pair | None = None

    @property
    def kind(self) -> str:
        """Which of the ways it is."""
        return next(kind for kind in KINDS if getattr(self, kind) is not None)

    @model_validator(mode="after")
    def _one_way(self) -> Vary:
        given = [kind for kind in KINDS if getattr(self, kind) is not None]
        if len(given) != 1:
            got = " and ".join(given) or "none"
            raise ValueError(f"varies in one way, got {got}, expected one of {', '.join(KINDS)}")
        [kind] = given
        misplaced = {
            "weights": self.weights is not None and kind != "choice",
            "bounds": self.bounds is not None and kind not in DISTRIBUTIONS[:4],
            "factor": self.factor != 1.0 and kind != "same_as",
            "offset": self.offset != 0.0 and kind != "same_as",
            "unit": self.unit is not None and kind == "same_as",
        }
        wrong = [key for key, is_wrong in misplaced.items() if is_wrong]
        if wrong:
            raise ValueError(f"{kind} with {' and '.join(wrong)}, expected {kind} without")
        self._check_order(kind)
        return self

    def _check_order(self, kind: str) -> None:
        """Refuse ranges that are empty or the wrong way round."""
        if kind in ("uniform", "linspace", "logspace"):
            low, high = getattr(self, kind)[:2]
            if not low < high:
                raise ValueError(f"{kind} from {low:g} to {high:g}, expected the smaller end first")
            if kind == "logspace" and low <= 0.0:
                raise ValueError(f"logspace from {low:g}, expected positive ends")
        if self.integers is not None and not self.integers[0] <= self.integers[1]:
            raise ValueError(
                f"integers from {self.integers[0]} to {self.integers[1]}, expected the smaller first"
            )
        if self.triangular is not None:
            low, mode, high = self.triangular
            if not (low <= mode <= high and low < high):
                raise ValueError(f"triangular {low:g}, {mode:g}, {high:g}, expected low <= mode <= high")
        if self.bounds is not None and not self.bounds[0] < self.bounds[1]:
            raise ValueError(
                f"bounds from {self.bounds[0]:g} to {self.bounds[1]:g}, expected the smaller first"
            )
        if self.weights is not None and self.choice is not None and len(self.weights) != len(self.choice):
            raise ValueError(f"{len(self.weights)} weights of {len(self.choice)} values, expected one each")


class Correlation(Section):
    """Correlation of two varied values, as that of the normal variables below them (Gaussian copula)."""

    of: tuple[str, str] = Field(examples=[["contact.k_p", "contact.c_p"]])
    value: Annotated[Finite, Field(gt=-1.0, lt=1.0)] = Field(examples=[0.6])


class Design(Section):
    """
    How runs are chosen: all combinations (grid) or a sample of `size` points.

    `saltelli` makes size (d + 2) runs for the Sobol indices of d varied values; `size` is a power of 2 there
    and for `sobol`, whose balance it keeps.
    """

    method: Literal["grid", "random", "latin_hypercube", "sobol", "saltelli"] = "grid"
    size: Annotated[Integer, Field(ge=1, le=10**8)] | None = None
    seed: Annotated[Integer, Field(ge=0, lt=2**32)] = 1

    @model_validator(mode="after")
    def _size_fits(self) -> Design:
        if self.method == "grid":
            if self.size is not None:
                raise ValueError(f"a grid of size {self.size}, expected no size: it has all combinations")
        elif self.size is None:
            raise ValueError(f"{self.method} without size, expected a number of points")
        elif self.method in ("sobol", "saltelli") and self.size & (self.size - 1):
            near = 1 << (self.size.bit_length() - 1)
            raise ValueError(
                f"{self.method} of size {self.size}, expected a power of 2, as {near} or {2 * near}"
            )
        return self


SHAPES = ("minimum", "maximum", "largest", "mean", "rms", "final")
MEASURE_KINDS = (*SHAPES, "first_crossing", "settling_time", "energy", "function")


class Measure(Section):
    """
    A number of each run, from the rows between `from` and `to` [s].

    `minimum`, `maximum`, `largest` (magnitude), `mean`, `rms`, `final` of a signal; `first_crossing` of
    `level` [s], rising or falling; `settling_time` [s]: the last time at which the signal is more than `band`
    from `level`; `energy`: the integral of a signal times the signal `with`; `function`: `file.py:name`,
    called with the time [s] and the signals by name, arrays of shape (rows,).
    """

    minimum: Signal | None = None
    maximum: Signal | None = None
    largest: Signal | None = None
    mean: Signal | None = None
    rms: Signal | None = None
    final: Signal | None = None
    first_crossing: Signal | None = None
    settling_time: Signal | None = None
    energy: Signal | None = None
    function: str | None = None
    level: Finite = 0.0
    band: Positive | None = None
    direction: Literal["rising", "falling", "either"] = "either"
    other: Signal | None = Field(None, alias="with")
    begin: Finite | None = Field(None, alias="from")
    end: Finite | None = Field(None, alias="to")

    @property
    def kind(self) -> str:
        """Which number it is."""
        return next(kind for kind in MEASURE_KINDS if getattr(self, kind) is not None)

    @property
    def signals(self) -> list[str]:
        """Signals that it needs by name."""
        found = [] if self.kind == "function" else [str(getattr(self, self.kind))]
        return found + ([] if self.other is None else [str(self.other)])

    @model_validator(mode="after")
    def _one_number(self) -> Measure:
        given = [kind for kind in MEASURE_KINDS if getattr(self, kind) is not None]
        if len(given) != 1:
            got = " and ".join(given) or "none"
            raise ValueError(
                f"a measure is one number, got {got}, expected one of {', '.join(MEASURE_KINDS)}"
            )
        if given == ["settling_time"] and self.band is None:
            raise ValueError("settling_time without band, expected the band around level that is settled")
        if given == ["energy"] and self.other is None:
            raise ValueError("energy without with, expected the signal that it is multiplied by")
        return self


ALL = "all"


def _metrics(value: Any) -> Any:
    return {ALL: list(NAMES), "none": []}.get(value, value) if isinstance(value, str) else value


def _metric(name: str) -> str:
    if name not in NAMES:
        raise ValueError(f"no such metric, expected {nearest(name, (*NAMES, ALL, 'none'))}")
    return name


def _signals(value: Any) -> Any:
    return {ALL: 1} if value == ALL else value


def _signal_or_all(name: str) -> str:
    return name if name == ALL else SignalName(name)


class Keep(Section):
    """
    What is kept of each run, next to inputs and outcome.

    `metrics`: those of the system's section `compare`, by name, `all` or `none`. `signals`: each n-th row of
    signals; `all` names all of them.
    """

    metrics: Annotated[list[Annotated[str, AfterValidator(_metric)]], BeforeValidator(_metrics), OrText()] = [
        *NAMES
    ]
    measures: Annotated[dict[Name, Measure], OrEmpty] = {}
    signals: Annotated[
        dict[Annotated[str, AfterValidator(_signal_or_all)], Annotated[Integer, Field(ge=1)]],
        OrEmpty,
        BeforeValidator(_signals),
        OrText(),
    ] = {}


class Until(Section):
    """Ends a campaign when the interval of a measure's mean is narrow enough; `diverged` is a probability."""

    measure: str = Field(examples=["diverged"])
    half_width: Positive = Field(examples=[0.005])
    confidence: Annotated[Finite, Field(gt=0.5, lt=1.0)] = 0.95
    fewest: Annotated[Integer, Field(ge=2)] = 100


class Constraint(Section):
    """A bound on a measure of a tuned system."""

    measure: str = Field(examples=["diverged"])
    over: Literal["mean", "worst", "median", "quantile"] = "mean"
    quantile: Annotated[Finite, Field(gt=0.0, lt=1.0)] = 0.95
    at_most: Finite = Field(examples=[0.0])


class Tune(Section):
    """
    Looks for the values of some variables at which a measure is smallest over the sample of `vary`.

    `values`: signal to its bounds [low, high]. `over`: mean, median, quantile or worst of the sample.
    """

    values: Annotated[dict[Signal, Pair], Field(min_length=1)] = Field(
        examples=[{"compensator.dpdc_phase": [0.0, 0.3]}]
    )
    minimise: str = Field(examples=["rms_s_des"])
    over: Literal["mean", "worst", "median", "quantile"] = "mean"
    quantile: Annotated[Finite, Field(gt=0.0, lt=1.0)] = 0.95
    constraints: list[Constraint] = []
    population: Annotated[Integer, Field(ge=5, le=1000)] = 15
    generations: Annotated[Integer, Field(ge=1, le=10000)] = 20
    seed: Annotated[Integer, Field(ge=0, lt=2**32)] = 1

    @field_validator("values")
    @classmethod
    def _in_order(cls, values: Mapping[Signal, Pair]) -> Mapping[Signal, Pair]:
        for signal, (low, high) in values.items():
            if not low < high:
                raise ValueError(f"{signal} from {low:g} to {high:g}, expected the smaller bound first")
        return values


class Campaign(Section):
    """
    A whole campaign.

    `vary` names `instance.variable`, a place of the system's file (`connections[contact.s_act].delay`,
    `events[0].at`, `coupling.order`, `inputs[0].file`, `fmus.contact.source`), `method` (of the compensator,
    as `dockloop compare-methods` names them), or `seed`, which gives each parameter of that name its value.
    """

    name: Name | None = None
    description: str = ""
    system: str = Field(examples=["experiment"])
    variant: str | None = None
    stop_time: Seconds | None = None
    step_size: Seconds | None = None
    flavour: Literal["native", "fmi3", "python"] = "native"
    set: Annotated[dict[Signal, Any], OrEmpty] = {}
    vary: Annotated[dict[str, Vary], OrEmpty] = {}
    correlations: list[Correlation] = []
    design: Design = Design()
    keep: Keep = Keep()
    until: Until | None = None
    tune: Tune | None = None
    time_limit: Seconds = 600.0

    @classmethod
    def stand_in(cls, key: str, data: Mapping[str, Any]) -> Any:
        return None

    @model_validator(mode="after")
    def _fits_together(self) -> Campaign:
        if self.until is not None and self.design.method in ("grid", "saltelli"):
            raise ValueError(
                f"until with design {self.design.method}, expected a sample that may end early: "
                "random, latin_hypercube or sobol"
            )
        if not self.vary and self.tune is None:
            raise ValueError("nothing varies, expected entries in vary or tune")
        return self


def read_campaign(path: Path) -> tuple[Campaign, Document]:
    """
    Read a campaign.

    Raises:
        ConfigError: With every fault of the file.
    """
    document = read_yaml(path)
    return validated(Campaign, document, "campaign"), document


def campaign_of(document: Document) -> Campaign:
    """Read a campaign that is data already, as `read_campaign` does."""
    return validated(Campaign, document, "campaign")
