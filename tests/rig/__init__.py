"""A docking rig in software with a known truth; see README.md."""

from .parts import LISTED, SUBSYSTEM, UNLISTED, Effects, Plant, Recorder
from .recording import COLUMNS, Recording, T, record

__all__ = [
    "COLUMNS",
    "LISTED",
    "SUBSYSTEM",
    "UNLISTED",
    "Effects",
    "Plant",
    "Recorder",
    "Recording",
    "T",
    "record",
]
