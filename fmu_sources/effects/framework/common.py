"""Declarations that several effects share."""

from __future__ import annotations

from ...framework.variables import Variable, parameter

SMOOTHING = "smoothing"
SMOOTHING_SHARE = 0.02
"""Typical smoothing, of the rms of the velocity."""

SMALLEST_SMOOTHING, SMALLEST_SHARE = 0.1, 1e-4
"""Smallest values in a fit over typical ones: of a smoothing, which looks alike when sharper; of others."""

NEVER = 1e9
"""A limit that is never reached."""


def smoothing(start: float = 1e-3) -> Variable:
    """Declare the velocity over which a sign is rounded."""
    return parameter(
        SMOOTHING, start, "{position}/s", "Velocity over which the sign is rounded, v_0", above=0.0
    )


def level(description: str) -> Variable:
    """Declare the size of a force that only takes energy."""
    return parameter("level", 0.0, "{value}", description, minimum=0.0)
