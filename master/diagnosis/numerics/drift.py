"""
Parameter or effect: does a refitted parameter stay where it is, along amplitude, temperature or time?

A parameter that is fitted alone on each of several groups of rows, and whose values differ by more than
their own uncertainty explains, is not a wrong number but a sign of a missing law. The slope along the group's
covariate names the kind: stiffness that grows with amplitude is hardening, one that falls with time is
warming.

Source: Cochran's test of homogeneity, Biometrics 10 (1954) 101; weighted least squares.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import stats

from .arrays import Array

ALPHA = 0.01  # chance of such differences below which a parameter is not one number


class Trend(NamedTuple):
    """Slope of a parameter along a covariate and its standard deviation."""

    slope: float
    deviation: float


@dataclass(frozen=True)
class Drift:
    """
    What a parameter does over the groups.

    `p_equal` is the chance of such differences if the parameter were one number. `along` is the covariate
    with the strongest trend, `slope` its change per unit of it with standard deviation `slope_deviation`,
    or None.
    """

    parameter: str
    values: Array
    p_equal: float
    along: str | None
    slope: float
    slope_deviation: float

    @property
    def is_constant(self) -> bool:
        """Whether one number fits all groups."""
        return self.p_equal >= ALPHA


def drift(parameter: str, values: Array, deviations: Array, covariates: Mapping[str, Array]) -> Drift:
    """
    Judge one parameter over groups of rows.

    Args:
        parameter: Its name.
        values: Fitted in each group, shape (groups,).
        deviations: Standard deviations of the values.
        covariates: For example `amplitude`, `velocity`, `time`: mean over each group, shape (groups,).
    """
    weights = 1.0 / deviations**2
    mean = float(np.sum(weights * values) / np.sum(weights))
    q = float(np.sum(weights * (values - mean) ** 2))
    p_equal = float(stats.chi2.sf(q, len(values) - 1))
    trends = {name: _trend(values, weights, c) for name, c in covariates.items()}
    along = max(trends, key=lambda name: abs(trends[name].slope / trends[name].deviation), default=None)
    if along is None or p_equal >= ALPHA:
        return Drift(parameter, values, p_equal, None, 0.0, 0.0)
    return Drift(parameter, values, p_equal, along, trends[along].slope, trends[along].deviation)


def _trend(values: Array, weights: Array, covariate: Array) -> Trend:
    """Weighted slope along a covariate, both shape (groups,)."""
    centre = np.sum(weights * covariate) / np.sum(weights)
    spread = float(np.sum(weights * (covariate - centre) ** 2))
    if spread <= 0.0:
        return Trend(0.0, 1.0)
    slope = float(np.sum(weights * (covariate - centre) * values) / spread)
    return Trend(slope, float(1.0 / np.sqrt(spread)))
