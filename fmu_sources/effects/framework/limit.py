"""What a law becomes at the ends of its parameters: another law, or a change of the base's own parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from .rms import Rms

Values = Mapping[str, float]
NEGLIGIBLE = 0.02
"""Share of a force, or of a motion, below which a part is lost in the rest."""

NEGLIGIBLE_WAY = 1e-3
"""Share of a motion within which a force may build up unseen: near its reversals a motion is slow."""


@dataclass(frozen=True, kw_only=True)
class Limit:
    """
    One end of a law's parameters.

    `is_reached` says so of the parameters in a slot whose signals have the sizes `Rms`. There the law is the
    effect `becomes`, with the parameters that `values` gives; None for what the base has itself, a spring or
    a damper. `because` says why.
    """

    becomes: str | None
    is_reached: Callable[[Values, Rms], bool]
    because: str
    values: Callable[[Values], Values] = lambda _: {}
