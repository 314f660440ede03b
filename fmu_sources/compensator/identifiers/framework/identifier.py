"""What an identifier is: where the process parameters Y = (a, b, c, d, e) of Eq. 15 come from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from ....framework.arithmetic import Arithmetic
from ....framework.variables import Variable
from ...tuning import Tuning
from .recursion import Settings

Vector = tuple[Any, ...]


class Measurement(NamedTuple):
    """What a period gives: the regressors H, the force Z [N] that H Y should be, and Y before it."""

    H: Vector
    Z: Any
    Y: Vector


class Estimate(NamedTuple):
    """Y after a measurement, and the next values of the identifier's own states."""

    Y: Vector
    states: Mapping[str, Any] = {}


@dataclass(frozen=True, kw_only=True)
class Identifier:
    """
    One identifier with its declarations.

    It sets the covariance recursion that least-squares identifiers share (`settings`), or it gives Y itself
    (`estimate`); it has one of the two. `number` is its value in the FMU's enumeration and never changes.
    `held_by` names the Boolean parameter that stops it; None for one that does not learn. One that learns
    starts from the assumed parameters with the smaller gain `prior_gain`. `parameters` and sampled `states`
    are its own; the states keep still while another identifier is chosen.
    """

    name: str
    number: int
    held_by: str | None
    settings: Callable[[Vector, Tuning, Any, Arithmetic], Settings] | None = None
    estimate: Callable[[Measurement, Any, Any, Arithmetic], Estimate] | None = None
    parameters: tuple[Variable, ...] = ()
    states: tuple[Variable, ...] = ()

    def __post_init__(self) -> None:
        """Refuse an identifier that has no law, or two."""
        if (self.settings is None) == (self.estimate is None):
            raise ValueError(f"{self.name}: one of settings and estimate is needed, got both or none")
