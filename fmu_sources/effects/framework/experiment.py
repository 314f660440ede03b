"""Recordings that tell effects apart which one recording cannot: each effect names those that show it."""

from __future__ import annotations

from enum import Enum


class Experiment(Enum):
    """What to record; one that comes first is preferred."""

    REST_AND_SPEEDS = (
        "Record at rest and at several speeds of both directions: an offset stays where nothing moves."
    )
    LONG_REST = "Record at rest for longer, at the start and at the end."
    SLOW_REVERSALS = "Record slow reversals at several amplitudes, below and above the way of presliding."
    WHOLE_RANGE = "Record slow motion over the whole range of the position, to both sides."
    CHIRP = "Record a chirp up to some 20 Hz, and check the sensor with a known mass or a second sensor."
    OTHER_AMPLITUDE = (
        "Record another amplitude (three times and a third) and another speed of the same motion."
    )
