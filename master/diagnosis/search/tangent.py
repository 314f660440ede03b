"""The fitted model so far, linearised: residual and sensitivities on the rows that are fitted on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from master.diagnosis.numerics.arrays import TINY, Array, Mask
from master.diagnosis.numerics.least_squares import FAR, STEP, Fit, FreeParameter, bounded
from master.diagnosis.numerics.regression import Background, penalised

from .extended_model import ExtendedModel
from .first_order import FirstOrder
from .study import Study

STEP_OF_TANGENT = 10.0 * STEP  # of a parameter's scale: less noise of the replay than in a fit


class TangentGain(NamedTuple):
    """Share of the residual's power that responses take away, and their factors, shape (responses,)."""

    share: float
    factors: Array


class Tangent:
    """
    A fitted model, linearised.

    `residual` and each of `columns` have shape (fitted rows * outputs,), scaled like the residual of a fit.
    Effects that `first_order` covers are answered by it, the others by replays.
    """

    def __init__(
        self, study: Study, chosen: ExtendedModel, fitted: Fit, first_order: FirstOrder | None = None
    ) -> None:
        self.study = study
        self.first_order = first_order
        self.chosen = chosen
        self.fit = fitted
        self.parameters = (*study.base, *chosen.parameters)
        self.values = dict(chosen.fixed) | dict(fitted.values)
        self.base_values = {p.name: fitted.values[p.name] for p in study.base}
        self._left = self._over_scale(study.measured - fitted.predicted)
        self._sensitivities = [self._sensitivity(p) for p in self.parameters]
        self.residual = self._on_fitted_rows(self._left)
        self.columns = [self._on_fitted_rows(s) for s in self._sensitivities]
        self.prior = np.diag([p.prior_weight for p in self.parameters])
        self.prior_left = np.array([p.prior_distance(fitted.values[p.name]) for p in self.parameters])
        self._background = Background(self.residual, self.columns, self.prior, self.prior_left)
        self._alone: Array | None = None if chosen.effects else fitted.predicted

    @property
    def power(self) -> float:
        """Power of the residual that sensitivities leave, on the rows that are fitted on."""
        return self._background.power

    @property
    def known(self) -> dict[str, Array]:
        """Sensitivities by parameter."""
        return dict(zip([p.name for p in self.parameters], self.columns, strict=True))

    def response(self, model: ExtendedModel, values: Mapping[str, float]) -> Array:
        """Scaled change of the outputs by the last effect of a model, on the rows that are fitted on."""
        return self._on_fitted_rows(self._change(model, values))

    def held_out_share(self, model: ExtendedModel, values: Mapping[str, float]) -> float:
        """
        Share of the residual's power on the held-out rows that the last effect of a model takes away.

        Its size is found on the rows that are fitted on, with the parameters refitted, to first order. NaN
        where no held-out row was replayed.
        """
        change = self._change(model, values)
        rows = np.zeros(len(change), dtype=bool)
        for block in self.study.held_out:
            rows[block] = True
        rows &= np.isfinite(self.fit.predicted).all(axis=1) & (np.abs(change) < FAR).all(axis=1)
        if not rows.any():
            return np.nan
        without = self._left_on(rows, [])
        return 1.0 - self._left_on(rows, [change]) / max(without, TINY)

    def _left_on(self, rows: Mask, changes: Sequence[Array]) -> float:
        """Power on some rows that sensitivities and changes leave, fitted on those to fit on."""
        columns = [*self._sensitivities, *changes]
        if not columns:
            return float(np.sum(self._left[rows] ** 2))
        matrix = np.stack(columns, axis=-1)
        penalty = np.zeros((len(columns), len(columns)))
        penalty[: len(self.prior), : len(self.prior)] = self.prior @ self.prior
        centre = np.zeros(len(columns))
        weights = np.diag(self.prior)
        has_prior = np.flatnonzero(weights > 0.0)
        centre[has_prior] = self.prior_left[has_prior] / weights[has_prior]
        fitted = self.study.fit_rows
        step = penalised(matrix[fitted], self._left[fitted], penalty, centre)
        return float(np.sum((self._left - matrix @ step)[rows] ** 2))

    def _change(self, model: ExtendedModel, values: Mapping[str, float]) -> Array:
        """
        Scaled change of the outputs that the last effect of a model makes, on all rows.

        With effects in other slots it acts on the model without them: to first order the same, and built
        already. After effects in its own slot it sees what they return.
        """
        placed = model.effects[-1]
        own = {p.name: p.start for p in model.parameters} | dict(model.fixed) | dict(values)
        if self.first_order is not None and self.first_order.covers(placed, own):
            return bounded(self.first_order.change(placed, own))
        if any(e.place == placed.place for e in self.chosen.effects):
            given = self.values | dict(model.fixed) | dict(values)
            return self._over_scale(self.study.simulate(model.effects, given) - self.fit.predicted)
        if self._alone is None:
            self._alone = self.study.simulate((), self.base_values)
        given = self.base_values | {k: v for k, v in model.fixed.items() if k not in self.chosen.fixed}
        return self._over_scale(self.study.simulate((placed,), given | dict(values)) - self._alone)

    def gain(self, responses: Sequence[Array], low: Sequence[float]) -> TangentGain:
        """
        Regress the residual on responses of which no factor is below its bound.

        The share is NaN where a response has run away: an unstable replay promises nothing.
        """
        if any((np.abs(r) >= FAR).any() for r in responses):
            return TangentGain(np.nan, np.zeros(len(responses)))
        regressed = self._background.regressed(responses, low)
        return TangentGain(1.0 - regressed.power / self.power, regressed.factors)

    def _sensitivity(self, p: FreeParameter) -> Array:
        at = self.values[p.name]
        step = STEP_OF_TANGENT if at + STEP_OF_TANGENT * p.scale < p.high else -STEP_OF_TANGENT
        moved = self.study.simulate(self.chosen.effects, self.values | {p.name: at + step * p.scale})
        return self._over_scale(moved - self.fit.predicted) / step

    def _over_scale(self, values: Array) -> Array:
        return bounded(values / self.study.output_scale)

    def _on_fitted_rows(self, values: Array) -> Array:
        return np.asarray(values[self.study.fit_rows].ravel())
