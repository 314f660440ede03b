"""
The plugs of every method: what goes in, what comes out, and how it is connected.

At each sampling instant a method reads its inputs and sets both outputs; they are states, so that nothing
passes through a method between two instants. A method changes the force, the command, or both: the other one
it passes on, f_comp = f_mea or s_cmd = s_des.
"""

from __future__ import annotations

from ..compensator.ports import INPUTS
from ..framework.model import Terminal
from ..framework.variables import declare, fixed, parameter, sampled, state

SAMPLE_TIME = fixed(parameter("sample_time", 1e-3, "s", "Sampling period", above=0.0))

OUTPUTS = declare(
    sampled(state("f_comp", "N", "Compensated force to the spacecraft dynamics", output=True)),
    sampled(state("s_cmd", "m", "Command to the motion simulator", output=True)),
)

TERMINALS = (
    Terminal(
        "spacecraft",
        "dynamics",
        "Plug of the dynamics model",
        {"force": "f_comp", "displacement": "s_des", "velocity": "v_des", "acceleration": "a_des"},
    ),
    Terminal(
        "motion_simulator",
        "motion",
        "Plug of the motion simulator",
        {"command": "s_cmd", "displacement": "s_act"},
    ),
    Terminal(
        "docking",
        "contact",
        "Plug of the measured docking mechanism",
        {"force": "f_mea", "travel": "x"},
    ),
)

LATENCY = parameter("latency", 0.045, "s", "Delay of the loop tau that is compensated", minimum=0.0)
"""Default: 10 ms of the force sensor, 33 ms of lag and 2 ms of dead time of the motion simulator."""

STIFFNESS = parameter("stiffness", 30_255.0, "N/m", "Stiffness of the whole contact k", minimum=0.0)
"""Default: k_m k_p/(k_m + k_p) of the default contact."""

__all__ = ["INPUTS", "LATENCY", "OUTPUTS", "SAMPLE_TIME", "STIFFNESS", "TERMINALS"]
