"""
Values at which a measure is smallest over the sample: an optimisation whose every candidate is a campaign.

Source: Storn, Price, Differential evolution, Journal of Global Optimization 11 (1997), as scipy has it;
candidates that keep the constraints are better than all that do not (Deb, 2000).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, differential_evolution

from master.recording.whole_file import write_whole

from .campaign import Constraint, Tune
from .crew import Crew, Order
from .plan import Plan, plan_of
from .proven import NOT_EXACT
from .stepper import Row

Floats = NDArray[np.float64]

TUNED = "tuned.json"
_WORSE = 1e12  # what a candidate costs that breaks a constraint, and one of which a run has no number
_UNKNOWN = 1e24


class _Interrupted(Exception):  # noqa: N818  # no error: a search that was asked to end
    """The search is asked to end."""


class _Inexact(Exception):  # noqa: N818  # no error: a search that begins again
    """The fused form has shown other bits."""


@dataclass(frozen=True)
class Tuned:
    """
    What a search has found.

    `values` by signal; `objective` is the measure there, over the sample, `constraints`
    the bounded ones in their order;
    `is_feasible`: whether all are within their bounds and all runs have numbers.
    """

    measure: str
    over: str
    values: dict[str, float]
    objective: float | None
    constraints: list[float | None]
    is_feasible: bool
    candidates: int
    runs: int


def tune(plan: Plan, folder: Path, workers: int, is_over: Callable[[], bool]) -> Tuned | None:
    """
    Search for the values of `tune`, and keep them in the folder; None if it was asked to end before.

    A search that is in the folder is not made again.
    """
    kept = folder / TUNED
    if kept.is_file():
        return Tuned(**json.loads(kept.read_text(encoding="utf-8")))
    wanted = plan.campaign.tune
    assert wanted is not None
    try:
        try:
            found = _Search(plan, wanted, workers, is_over).run()
        except _Inexact:  # what it has found so far may be off
            found = _Search(plan, wanted, workers, is_over, is_apart=True).run()
    except _Interrupted:
        return None
    write_whole(kept, json.dumps(asdict(found), indent=2, allow_nan=False))
    return found


def at_optimum(plan: Plan, found: Tuned) -> Plan:
    """Return the campaign with the values that were found, and nothing more to tune."""
    campaign = plan.campaign
    values: dict[str, Any] = {str(signal): value for signal, value in campaign.set.items()}
    values |= found.values
    return plan_of(campaign.model_copy(update={"set": values, "tune": None}), plan.document)


class _Search:
    def __init__(
        self, plan: Plan, wanted: Tune, workers: int, is_over: Callable[[], bool], *, is_apart: bool = False
    ) -> None:
        self.plan = plan
        self.wanted = wanted
        self.names = tuple(str(name) for name in wanted.values)
        self.crew = Crew(plan, workers)
        self.is_over = is_over
        self.is_apart = is_apart
        self.candidates = 0
        self.runs = 0

    def run(self) -> Tuned:
        """Search, and end the processes."""
        with closing(self.crew):
            return self._found()

    def _found(self) -> Tuned:
        wanted = self.wanted
        costs: Any = self._costs  # of many points at a time
        low, high = zip(*wanted.values.values(), strict=True)
        found = differential_evolution(
            costs,
            Bounds(low, high),
            popsize=max(1, -(-wanted.population // len(self.names))),
            maxiter=wanted.generations,
            rng=wanted.seed,
            polish=False,
            init="sobol",
            updating="deferred",
            vectorized=True,
            tol=1e-6,
        )
        best = dict(zip(self.names, map(float, found.x), strict=True))
        [rows] = self._rows([best])
        objective, constraints = self._judged(rows)
        bounds = [constraint.at_most for constraint in wanted.constraints]
        pairs = zip(constraints, bounds, strict=True)
        is_feasible = objective is not None and all(v is not None and v <= bound for v, bound in pairs)
        return Tuned(
            wanted.minimise,
            wanted.over,
            best,
            objective,
            constraints,
            is_feasible,
            self.candidates,
            self.runs,
        )

    def _costs(self, points: Floats) -> Floats:
        """Costs of candidates, shape (candidates,), of points of shape (values, candidates)."""
        candidates = [dict(zip(self.names, map(float, point), strict=True)) for point in points.T]
        return np.array([self._cost(rows) for rows in self._rows(candidates)])

    def _rows(self, candidates: Sequence[Mapping[str, float]]) -> list[list[Row]]:
        """Make all runs of some candidates."""
        runs = range(self.plan.sample.n_runs)
        orders = (Order(run, candidate, is_apart=self.is_apart) for candidate in candidates for run in runs)
        found: dict[tuple[float, ...], list[Row]] = {}
        for row in self.crew.rows(orders, self.is_over, keep=True):
            if row is not None:
                if row.made == NOT_EXACT and not self.is_apart:
                    raise _Inexact
                key = tuple(row.values[name] for name in self.names)
                found.setdefault(key, []).append(row)
        if self.is_over():
            raise _Interrupted
        self.candidates += len(candidates)
        self.runs += len(candidates) * len(runs)
        return [found[tuple(candidate.values())] for candidate in candidates]

    def _judged(self, rows: Sequence[Row]) -> tuple[float | None, list[float | None]]:
        wanted = self.wanted
        objective = _over(rows, wanted.minimise, wanted.over, wanted.quantile)
        return objective, [_constrained(rows, constraint) for constraint in wanted.constraints]

    def _cost(self, rows: Sequence[Row]) -> float:
        objective, constraints = self._judged(rows)
        if objective is None or None in constraints:
            return _UNKNOWN
        pairs = zip(constraints, self.wanted.constraints, strict=True)
        beyond = sum(max(0.0, (value or 0.0) - constraint.at_most) for value, constraint in pairs)
        return _WORSE * (1.0 + beyond) if beyond > 0.0 else objective


def _constrained(rows: Sequence[Row], constraint: Constraint) -> float | None:
    return _over(rows, constraint.measure, constraint.over, constraint.quantile)


def _over(rows: Sequence[Row], measure: str, over: str, quantile: float) -> float | None:
    """Return a measure over the sample; None where a run has none: the others are no fair sample."""
    values = [row.number(measure) for row in sorted(rows, key=lambda row: row.run)]
    known = np.array([value for value in values if value is not None])
    if len(known) < len(values):
        return None
    match over:
        case "worst":
            return float(np.max(known))
        case "median":
            return float(np.median(known))
        case "quantile":
            return float(np.quantile(known, quantile))
    return float(np.mean(known))
