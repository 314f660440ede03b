"""
The paper's Tables 1 to 3, once: figures and formulas read them here, and a test compares the configurations.

What is printed and what is chosen or fitted is said in `parameters.py`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from master.docking.plant import ThirdOrder
from master.reproduce.measures.contact import Loop

STEP = 1e-3  # s, sampling period of the paper
STIFFNESS_AMPLITUDE = 8e4  # N/m, by which the rope's stiffness varies in Sec. V-A.3
STIFFNESS_FREQUENCY = 1.0  # Hz


@dataclass(frozen=True)
class Table:
    """One column: the loop, offset at the start [m], time constant [s] and noise [N] of the force sensor."""

    loop: Loop
    offset: float
    T_f: float
    sigma: float


_LOW = Loop(m_s=820.0, m_e=80.0, k_m=150e3, c_m=158.0, k_p=37.9e3, c_p=65.0)
_HIGH = Loop(m_s=1000.0, m_e=60.0, k_m=800e3, c_m=800.0, k_p=400e3, c_p=400.0)
_HEAVY = Loop(m_s=4000.0, m_e=100.0, k_m=139.2e3, c_m=136.1, k_p=37.76e3, c_p=97.3)
_LIGHT = Loop(m_s=1000.0, m_e=100.0, k_m=139.2e3, c_m=136.1, k_p=37.76e3, c_p=97.3)

TABLES = {
    "S1": Table(_LOW, offset=-0.01, T_f=0.0, sigma=0.0316),
    "S2": Table(_HIGH, offset=-0.01, T_f=0.0, sigma=0.0316),
    "E1": Table(_HEAVY, offset=-0.005, T_f=0.01, sigma=0.0316),
    "E2": Table(_LIGHT, offset=-0.005, T_f=0.01, sigma=0.0316),
}

LINEAR_PLANT = ThirdOrder(K_p=30.0, w_v=2.0 * math.pi * 20.0, z=0.8, dead_time=0.002)
