"""Sizes of what is in a slot."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Rms:
    """Size of a slot's value and signals in a recording, for scaling a fit."""

    value: float = 1.0
    position: float = 1.0
    velocity: float = 1.0
    load: float = 1.0
    duration: float = 1.0
