"""Short ways to a compensator for the tests."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from fmu_sources.compensator.compensator import MODEL
from fmu_sources.framework.instance import Instance

T = 1e-3
OFF = {"fmdc": False, "cfdc": False, "dpdc": False}
CONTACTS = {
    "S1": {"m_e": 80.0, "k_m": 150e3, "c_m": 158.0, "k_p": 37.9e3, "c_p": 65.0},
    "E": {"m_e": 100.0, "k_m": 139.2e3, "c_m": 136.1, "k_p": 37.76e3, "c_p": 97.3},
    "E, other stiffness": {"m_e": 78.0, "k_m": 48587.0, "c_m": 125.23, "k_p": 84408.0, "c_p": 82.55},
    "S2": {"m_e": 60.0, "k_m": 8e5, "c_m": 800.0, "k_p": 4e5, "c_p": 400.0},
}


def parameters(contact: str) -> SimpleNamespace:
    """Give what the difference equations read."""
    return SimpleNamespace(sample_time=T, **CONTACTS[contact])


def make(**values) -> Instance:
    """Make and initialise a compensator with values set."""
    instance = Instance(MODEL)
    for name, value in values.items():
        instance[name] = value
    instance.initialise()
    return instance


def step(compensator: Instance, k: int, **inputs: float) -> None:
    """Set inputs and step one period."""
    for name, value in inputs.items():
        compensator[name] = value
    compensator.step(k * T, T)


def polynomials(contact: str) -> tuple[list[float], list[float]]:
    """Numerator and denominator of G(s), highest power first."""
    c = CONTACTS[contact]
    num = np.polymul([c["c_m"], c["k_m"]], [c["c_p"], c["k_p"]])
    return list(num), [c["m_e"], c["c_m"] + c["c_p"], c["k_m"] + c["k_p"]]
