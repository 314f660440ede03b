"""A second docking rig in software, from energies; see README.md."""

from .laws import LAWS, Law
from .recording import NONE, Nuisance, record

__all__ = ["LAWS", "NONE", "Law", "Nuisance", "record"]
