"""
Ball on a beam whose angle is measured.

    7/5 m q'' = m (q theta'^2 - g sin(theta)) - F,   F = c q'  (slot `friction`)

Inputs   theta [rad], der_theta [rad/s]
Outputs  q [m], der_q [m/s] (states)   direct feedthrough: none
States   q, der_q                      start: 0, the middle of the beam
Slots    friction: c q', of q and der_q
Source   Lagrange's equation of a solid ball that rolls; Hauser, Sastry, Kokotovic, IEEE Trans. Automatic
         Control 37 (1992) 392, without the term of the ball's own inertia in theta''.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import declare, input_, parameter, state
from .hold import held, input_hold


class BallAndBeam(Model):
    """See the module's text."""

    name = "ball_and_beam"
    description = "Ball on a beam whose angle is measured."
    variables = declare(
        parameter("mass", 0.1, "kg", "Mass m of the ball", above=0.0),
        parameter("gravity", 9.81, "m/s2", "Gravity g", minimum=0.0),
        parameter("damping", 0.05, "N s/m", "Viscous friction c", minimum=0.0),
        input_("theta", "rad", "Angle of the beam"),
        input_("der_theta", "rad/s", "Angular velocity of the beam"),
        state("q", "m", "Position of the ball", output=True),
        state("der_q", "m/s", "Velocity of the ball", output=True),
        input_hold(),
    )
    slots = (Slot("friction", "N", "Friction of the ball", {"q": "m", "der_q": "m/s"}),)
    delays = held("theta", "der_theta")
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        friction = slot("friction", p.damping * x.der_q, q=x.q, der_q=x.der_q)
        drive = p.mass * (x.q * u.der_theta * u.der_theta - p.gravity * m.sin(u.theta))
        return {"q": x.der_q, "der_q": (drive - friction) / (1.4 * p.mass)}


MODEL = BallAndBeam()
