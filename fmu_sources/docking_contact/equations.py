"""
The contact equations that the contact model and the real docking share, Eqs. 5, 7, 9.

    x_d       = x_e + x,   r = s - x_d                                                           (5)
    k_p(t)    = k_p + k_p_amplitude sin(2 pi k_p_frequency t)
    m_e x_e'' = -k_m x_e - c_m x_e' + k_p(t) r + c_p r'                                          (7)
    f         = -k_m x_e - c_m x_e'                                                              (9)

Source   Paper, Sec. III-C. Eq. 7 prints c_p (s_act - x_d'); r' = s' - x_e' - v is used, as Eq. 8 requires.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Linear, Slot, SlotFunction
from ..framework.variables import parameter

PARAMETERS = (
    parameter("m_e", 80.0, "kg", "Mass of end-effector and manipulator", above=0.0),
    parameter("k_m", 150_000.0, "N/m", "Stiffness of the manipulator", above=0.0),
    parameter("c_m", 158.0, "N s/m", "Damping of the manipulator", minimum=0.0),
    parameter("k_p", 37_900.0, "N/m", "Stiffness of the rope", above=0.0),
    parameter("c_p", 65.0, "N s/m", "Damping of the rope", minimum=0.0),
    parameter("k_p_amplitude", 0.0, "N/m", "Amplitude of the variation of k_p", minimum=0.0),
    parameter("k_p_frequency", 1.0, "Hz", "Frequency of the variation of k_p", minimum=0.0),
)

LINEAR = (
    Linear(
        "k_p_amplitude", 0.0, "a stiffness that varies with time stays at its mean", frequency="k_p_frequency"
    ),
)

SLOTS = (
    Slot("rope_force", "N", "Force of the rope, positive where it pulls r back", {"r": "m", "der_r": "m/s"}),
    Slot(
        "guide_force",
        "N",
        "Force of the guide, positive against x_e; none in the paper",
        {"x_e": "m", "der_x_e": "m/s", "load": "N"},
    ),
    Slot(
        "manipulator_force",
        "N",
        "Force of the manipulator, positive against x_e",
        {"x_e": "m", "der_x_e": "m/s"},
    ),
)


def equilibrium(s: Any, x: Any, p: Any) -> Any:
    """Give x_e [m] at rest for a displacement s [m] and a drag travel x [m], with the mean k_p."""
    return p.k_p / (p.k_m + p.k_p) * (s - x)


def contact_force(x: Any, p: Any, slot: SlotFunction) -> Any:
    """Give the force [N] at the sensor on the frame side, Eq. 9."""
    return -slot("manipulator_force", p.k_m * x.x_e + p.c_m * x.der_x_e, x_e=x.x_e, der_x_e=x.der_x_e)


def rope_stiffness(t: Any, p: Any, m: Arithmetic) -> Any:
    """Give the stiffness [N/m] of the rope at t [s]."""
    return p.k_p + p.k_p_amplitude * m.sin(2.0 * m.pi * p.k_p_frequency * t)


def rope_force(end: tuple[Any, Any], v: Any, x: Any, k_p: Any, p: Any, slot: SlotFunction) -> Any:
    """Give the force [N] of the rope on the end-effector; `end` is its other end (position, velocity)."""
    r = end[0] - (x.x_e + x.x)
    der_r = end[1] - (x.der_x_e + v)
    return slot("rope_force", k_p * r + p.c_p * der_r, r=r, der_r=der_r)


def acceleration(f_m: Any, f_r: Any, x: Any, p: Any, slot: SlotFunction) -> Any:
    """Give x_e'' [m/s2] from the forces [N] of manipulator and rope, Eq. 7."""
    f_g = slot("guide_force", 0.0, x_e=x.x_e, der_x_e=x.der_x_e, load=f_r)
    return (f_m + f_r - f_g) / p.m_e
