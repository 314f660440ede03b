"""
A named law as it acted in its slot: what it adds, over which signals, and what was measured there.

What is left of the outputs is brought back to the slot through their linear response to what is added there:

    left = sum over bins b of R(1_b) c_b,     measured in bin b = mean of the law there + c_b

with 1_b one while the signal is in the bin. Where the outputs answer at once (the inverse of a model), each
row is a point by itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from fmu_sources.effects.framework.effect import Applied
from fmu_sources.effects.framework.roles import Signals
from fmu_sources.framework.array_arithmetic import ARRAYS
from master.diagnosis.judge.part_result import PartResult
from master.diagnosis.numerics.arrays import Array, Integers, Mask
from master.diagnosis.numerics.deviations import sandwich
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.numerics.step_answers import CONSTANT
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.search.injection import Injection

TIME, VALUE = "time", "value"
N_BINS = 13  # by rows, and as many of equal width
LEAST_WIDTH = 0.004  # of a bin over the range
FEWEST_ROWS = 10
UNRESOLVED = 0.5  # deviation of a bin over the range of the law, above which it says nothing
N_GRID = 801
N_TRIED = 400  # samples on which a law is asked which signals it depends on
SAME = 1e-9
TWO = 2.0  # deviations of the band
DIFFERENCE = 1e-3  # of a parameter's deviation, for a derivative

WINDOWED = "the part is replayed in windows, and the response to a slot is known over whole recordings only"
NOT_LINEAR = "the outputs do not respond in proportion to what is added in the slot"
WITH_MEMORY = (
    "the law is no function of one signal, and the outputs respond to the slot with a memory of their own: "
    "what is left cannot be told apart into single values of the law"
)
HIDDEN = "the states of the law are hidden in its FMU, and what it adds is not known without them"
DIVERGED = "the replay of the model with the law is not finite"


@dataclass(frozen=True)
class LawCurve:
    """A law over one signal: shape (n,), `low` and `high` by the covariance of its parameters."""

    x: Array
    y: Array
    low: Array
    high: Array


@dataclass(frozen=True)
class MeasuredInSlot:
    """
    What was measured in a slot.

    `x`, `y` and `deviation` are of bins, shape (bins,); `cloud_x`, `cloud_y` of single rows, shape (rows,),
    where the outputs respond at once. `n_unresolved` bins are known too badly to be drawn.
    """

    x: Array
    y: Array
    deviation: Array
    cloud_x: Array
    cloud_y: Array
    n_unresolved: int = 0


@dataclass(frozen=True)
class LawOver:
    """A law over one role of its slot's signals; `curve` where it is a function of that signal alone."""

    role: str
    x: Array
    curve: LawCurve | None = None
    measured: MeasuredInSlot | None = None


@dataclass(frozen=True)
class LawInSlot:
    """
    A named law along the replay of the model that holds it.

    `added` is what it adds at every sample, shape (samples,), `recordings` the first sample of each
    recording; both empty where `why_not` says why nothing can be drawn. `why_no_points` says why nothing
    measured is drawn with it.
    """

    placed: PlacedEffect
    added: Array = field(default_factory=lambda: np.zeros(0))
    recordings: tuple[int, ...] = ()
    over: tuple[LawOver, ...] = ()
    why_not: str = ""
    why_no_points: str = ""


def law_in_slot(part: PartResult, placed: PlacedEffect) -> LawInSlot:
    """
    Find out what can be drawn of one effect of the model that was chosen.

    Args:
        part: The part that holds it.
        placed: One of `part.chosen.effects`.
    """
    applied = _Applied.of(part, placed)
    if isinstance(applied, str):
        return LawInSlot(placed, why_not=applied)
    bench = part.study.bench
    added = applied.added
    role = applied.only_role()
    shown = [role] if role is not None else applied.roles
    response = _Response.of(part, placed)
    points: dict[str, MeasuredInSlot] = {}
    why = response
    if isinstance(response, _Response):
        why = "" if role is not None or response.is_at_once else WITH_MEMORY
        if not why:
            points = {r: response.measured(applied.signals[r], added, binned=role is not None) for r in shown}
    over = tuple(
        LawOver(
            role=shown_role,
            x=applied.signals[shown_role],
            curve=None if role is None else applied.curve(role, part.fit),
            measured=points.get(shown_role),
        )
        for shown_role in shown
    )
    first = tuple(bench.first_sample(name) for name in bench.recordings)
    return LawInSlot(placed, added, first, over, why_no_points=str(why))


@dataclass(frozen=True)
class _Applied:
    """A law on the signals (samples,) that it meets, by role, and on its own states, by their short names."""

    placed: PlacedEffect
    signals: Mapping[str, Array]
    states: Mapping[str, Array]
    values: Mapping[str, float]

    @classmethod
    def of(cls, part: PartResult, placed: PlacedEffect) -> _Applied | str:
        """Follow the effects of a slot up to one of them; why that is not possible otherwise."""
        study = part.study
        values = part.values
        replayed = study.bench.record(
            study.pool.player_with_states(part.chosen.effects), study.values_with(values)
        )
        slot = study.slot_signals_with(part.chosen, values, placed.place)
        signals = {**slot, TIME: study.bench.times}
        for effect in part.chosen.effects:
            if effect.place != placed.place:
                continue
            names = [v.name for v in effect.law.states]
            if any(effect.variable(name) not in replayed for name in names):
                return HIDDEN
            states = {name: replayed[effect.variable(name)] for name in names}
            applied = cls(effect, signals, states, values)
            if not np.isfinite(applied.added).all():
                return DIVERGED
            if effect == placed:
                return applied
            signals = applied.after()
        raise KeyError(placed)

    @property
    def added(self) -> Array:
        """What the law adds at every sample, shape (samples,)."""
        return self._added(self.signals, self.states, self.values)

    @property
    def roles(self) -> list[str]:
        """Signals that the law is drawn over: those that it asks for, else the value or the time."""
        return [*self.placed.law.needs] or [VALUE if self._depends_on(VALUE) else TIME]

    def only_role(self) -> str | None:
        """Name the one signal that decides what the law adds, the time of a constant; None if more do."""
        if self.states:
            return None
        deciding = [role for role in self.signals if self._depends_on(role)]
        return None if len(deciding) > 1 else deciding[0] if deciding else TIME

    def after(self) -> dict[str, Array]:
        """Signals as a later effect of the slot meets them."""
        applied = self._law(self.signals, self.states, self.values)
        changed = {VALUE: applied.value, **applied.signals}
        n = len(self.signals[VALUE])
        return {**self.signals, **{role: np.broadcast_to(v, (n,)) for role, v in changed.items()}}

    def curve(self, role: str, fit: Fit) -> LawCurve:
        """Lay the law out over the range of the one signal that decides it."""
        own = self.signals[role]
        even = np.linspace(own.min(), own.max(), N_GRID)
        x = np.union1d(even, np.quantile(own, _shares(N_GRID)))
        grid = {r: np.full(len(x), np.median(v)) for r, v in self.signals.items()} | {role: x}
        y = self._added(grid, {}, self.values)
        names = [name for name in fit.values if self.placed.owns(name)]
        if not names:
            return LawCurve(x, y, y, y)
        slopes = np.stack([self._slope(grid, y, name, fit.deviations.get(name, 0.0)) for name in names])
        places = [list(fit.values).index(name) for name in names]
        covariance = fit.covariance
        if covariance is None:
            covariance = np.diag([fit.deviations.get(name, 0.0) ** 2 for name in fit.values])
        variance = np.einsum("ik,ij,jk->k", slopes, covariance[np.ix_(places, places)], slopes)
        band = TWO * np.sqrt(np.maximum(variance, 0.0))
        return LawCurve(x, y, y - band, y + band)

    def _slope(self, grid: Mapping[str, Array], y: Array, name: str, deviation: float) -> Array:
        """Derivative of the law to one of its parameters, shape (n,): zero for one that has no deviation."""
        step = DIFFERENCE * deviation
        if not step > 0.0 or not np.isfinite(step):
            return np.zeros(len(y))
        moved = self._added(grid, {}, {**self.values, name: self.values[name] + step})
        return np.nan_to_num((moved - y) / step)

    def _depends_on(self, role: str) -> bool:
        """Whether other values of a signal change what the law adds."""
        n = len(self.signals[VALUE])
        rows = np.unique(np.linspace(0, n - 1, min(n, N_TRIED)).astype(int))
        here = {r: v[rows] for r, v in self.signals.items()}
        states = {name: v[rows] for name, v in self.states.items()}
        added = self._added(here, states, self.values)
        scale = np.abs(added).max() + np.abs(here[VALUE]).max()
        tried = (np.roll(here[role], 1), here[role][::-1], np.full(len(rows), np.median(here[role])))
        return any(
            bool(np.abs(self._added({**here, role: other}, states, self.values) - added).max() > SAME * scale)
            for other in tried
        )

    def _added(
        self, signals: Mapping[str, Array], states: Mapping[str, Array], values: Mapping[str, float]
    ) -> Array:
        with np.errstate(all="ignore"):
            return np.asarray(self._law(signals, states, values).value - signals[VALUE] + 0.0 * signals[TIME])

    def _law(
        self, signals: Mapping[str, Array], states: Mapping[str, Array], values: Mapping[str, float]
    ) -> Applied:
        law = self.placed.law
        p = law.parameter_record.record(
            [float(values.get(self.placed.variable(v.name), v.start)) for v in law.parameters]
        )
        x = law.state_record.record([states[v.name] for v in law.states])
        s = Signals(**{role: v for role, v in signals.items() if role in Signals._fields})
        return law.law(signals[TIME], signals[VALUE], s, x, p, ARRAYS)


@dataclass(frozen=True)
class _Response:
    """What is left of a part, and how its outputs respond to a slot."""

    part: PartResult
    injection: Injection

    @classmethod
    def of(cls, part: PartResult, placed: PlacedEffect) -> _Response | str:
        """Ask for the response of the model without effects; why there is none otherwise."""
        if part.study.bench.is_windowed:
            return WINDOWED
        own = {k: v for k, v in part.fit.values.items() if not any(e.owns(k) for e in part.chosen.effects)}
        injection = Injection(part.study, placed.place, own)
        return cls(part, injection) if injection.is_linear else NOT_LINEAR

    @property
    def is_at_once(self) -> bool:
        """Whether the outputs respond within the row, and no later."""
        return all(
            bool((np.abs(step - step[0]).max(axis=0) <= CONSTANT * np.abs(step[0])).all())
            and bool(np.any(step[0]))
            for step in self.injection.steps.values()
        )

    def measured(self, signal: Array, added: Array, *, binned: bool) -> MeasuredInSlot:
        """
        What was measured in the slot on the open rows, over one of its signals.

        Args:
            signal: Shape (samples,).
            added: What the law adds, shape (samples,).
            binned: Whether means over bins of the signal are wanted too.
        """
        study = self.part.study
        rows = _open_rows(self.part)
        left = ((study.measured - self.part.fit.predicted) / study.output_scale)[rows]
        none = np.zeros(0)
        cloud_x = none
        cloud_y = none
        if self.is_at_once:
            first = next(iter(self.injection.steps.values()))
            gains = first[0] / study.output_scale
            cloud_x = study.bench.compared_rows(signal)[rows]
            cloud_y = study.bench.compared_rows(added)[rows] + left @ gains / (gains @ gains)
        if not binned:
            return MeasuredInSlot(none, none, none, cloud_x, cloud_y)
        place = bins(signal)
        inside = (place[:, None] == np.arange(place.max() + 1)).astype(float)
        count = inside.sum(axis=0)
        matrix = self.injection.answer(inside)[rows].reshape(-1, inside.shape[1])
        means = np.linalg.lstsq(matrix, left.ravel(), rcond=None)[0]
        rest = left.ravel() - matrix @ means
        deviation = np.sqrt(np.maximum(np.diag(sandwich(matrix, rest, left.shape[1], 0)), 0.0))
        size = max(float(np.ptp(added)), float(np.abs(added).max()))
        resolved = np.any(matrix != 0.0, axis=0) & (deviation < UNRESOLVED * size)
        y = inside.T @ added / count + means
        return MeasuredInSlot(
            x=(inside.T @ signal / count)[resolved],
            y=y[resolved],
            deviation=deviation[resolved],
            cloud_x=cloud_x,
            cloud_y=cloud_y,
            n_unresolved=int(np.sum(~resolved)),
        )


def bins(signal: Array) -> Integers:
    """
    Number the bin of each sample, shape (samples,).

    Edges are quantiles of the signal and even steps of its range, where enough samples and width are left.
    """
    low, high = float(signal.min()), float(signal.max())
    proposed = np.union1d(np.quantile(signal, _shares(N_BINS + 1)), np.linspace(low, high, N_BINS + 1))[1:-1]
    ordered = np.sort(signal)
    edges = [low]
    for edge in proposed:
        enough = np.searchsorted(ordered, edge) - np.searchsorted(ordered, edges[-1]) >= FEWEST_ROWS
        rest = len(ordered) - np.searchsorted(ordered, edge) >= FEWEST_ROWS
        if enough and rest and edge - edges[-1] >= LEAST_WIDTH * (high - low):
            edges.append(float(edge))
    return np.asarray(np.searchsorted(np.array(edges[1:]), signal, side="right"), dtype=np.int64)


def _shares(n: int) -> Array:
    return np.linspace(0.0, 1.0, n)


def _open_rows(part: PartResult) -> Mask:
    """Rows that are fitted on or selected by, shape (rows,)."""
    study = part.study
    rows = study.fit_rows.copy()
    for block in study.held_out:
        rows[block] = True
    return rows & np.isfinite(part.fit.predicted).all(axis=1)
