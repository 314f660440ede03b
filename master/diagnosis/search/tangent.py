"""The fitted model so far, linearised: residual and sensitivities on the rows that are fitted on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.least_squares import STEP, Fit, FreeParameter, bounded
from master.diagnosis.numerics.regression import Regressed, bounded_below

from .extended_model import ExtendedModel
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
    """

    def __init__(self, study: Study, chosen: ExtendedModel, fitted: Fit) -> None:
        self.study = study
        self.chosen = chosen
        self.fit = fitted
        self.parameters = (*study.base, *chosen.parameters)
        self.values = dict(chosen.fixed) | dict(fitted.values)
        self.base_values = {p.name: fitted.values[p.name] for p in study.base}
        self.residual = self._scaled(study.measured - fitted.predicted)
        self.columns = [self._sensitivity(p) for p in self.parameters]
        self.prior = np.diag([p.prior_weight for p in self.parameters])
        self.prior_left = np.array([p.prior_distance(fitted.values[p.name]) for p in self.parameters])
        self.power = self._regressed([], []).power
        self._alone: Array | None = None if chosen.effects else fitted.predicted

    @property
    def known(self) -> dict[str, Array]:
        """Sensitivities by parameter."""
        return dict(zip([p.name for p in self.parameters], self.columns, strict=True))

    def response(self, model: ExtendedModel, values: Mapping[str, float]) -> Array:
        """
        Scaled change of the outputs that the last effect of a model makes, on the rows that are fitted on.

        With effects in other slots it acts on the model without them: to first order the same, and built
        already. After effects in its own slot it sees what they return.
        """
        placed = model.effects[-1]
        if any(e.place == placed.place for e in self.chosen.effects):
            given = self.values | dict(model.fixed) | dict(values)
            return self._scaled(self.study.simulate(model.effects, given) - self.fit.predicted)
        if self._alone is None:
            self._alone = self.study.simulate((), self.base_values)
        given = self.base_values | {k: v for k, v in model.fixed.items() if k not in self.chosen.fixed}
        return self._scaled(self.study.simulate((placed,), given | dict(values)) - self._alone)

    def gain(self, responses: Sequence[Array], low: Sequence[float]) -> TangentGain:
        """Regress the residual on responses of which no factor is below its bound."""
        regressed = self._regressed(responses, low)
        return TangentGain(1.0 - regressed.power / self.power, regressed.factors)

    def _regressed(self, responses: Sequence[Array], low: Sequence[float]) -> Regressed:
        return bounded_below(self.residual, self.columns, self.prior, self.prior_left, responses, low)

    def _sensitivity(self, p: FreeParameter) -> Array:
        at = self.values[p.name]
        step = STEP_OF_TANGENT if at + STEP_OF_TANGENT * p.scale < p.high else -STEP_OF_TANGENT
        moved = self.study.simulate(self.chosen.effects, self.values | {p.name: at + step * p.scale})
        return self._scaled(moved - self.fit.predicted) / step

    def _scaled(self, values: Array) -> Array:
        return np.asarray(bounded(values / self.study.output_scale)[self.study.fit_rows].ravel())
