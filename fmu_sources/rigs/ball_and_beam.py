"""
Ball that rolls on a beam whose angle is measured.

    (1 + e) m q'' = m (q angle'^2 + g sin(angle)) - F,   F = b q'  (slot `friction`)

Inputs   angle [rad], der_angle [rad/s]    positive where the ball rolls towards larger q
Outputs  q [m], der_q [m/s] (states)       direct feedthrough: none
States   q, der_q                          start: 0, at the axis of the beam
Slots    friction: b q', of q and der_q
Source   Hauser, Sastry, Kokotovic, IEEE TAC 37(3) (1992).
Limits   Rolls without slipping; e = 2/5 for a full ball on its equator, more in a groove.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.model import InputHold, Model, Slot, SlotFunction, Values, no_effect
from ..framework.variables import choice, declare, input_, parameter, state


class BallAndBeam(Model):
    """See the module's text."""

    name = "ball_and_beam"
    description = "Ball that rolls on a beam whose angle is measured."
    variables = declare(
        parameter("mass", 0.05, "kg", "Mass m of the ball", above=0.0),
        parameter("rolling_inertia", 0.4, "1", "Inertia of rolling over that of moving e", minimum=0.0),
        parameter("damping", 0.0, "N s/m", "Viscous friction b", minimum=0.0),
        parameter("gravity", 9.81, "m/s2", "Gravity g", above=0.0),
        choice("input_hold", InputHold.interpolate, "What the inputs are during a step"),
        input_("angle", "rad", "Angle of the beam"),
        input_("der_angle", "rad/s", "Rate of that angle"),
        state("q", "m", "Distance of the ball from the axis", output=True),
        state("der_q", "m/s", "Velocity along the beam", output=True),
    )
    slots = (Slot("friction", "N", "Resistance to rolling", {"q": "m", "der_q": "m/s"}),)
    input_hold = "input_hold"

    def derivatives(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        friction = slot("friction", p.damping * x.der_q, q=x.q, der_q=x.der_q)
        drive = p.mass * (x.q * u.der_angle * u.der_angle + p.gravity * m.sin(u.angle))
        return {"q": x.der_q, "der_q": (drive - friction) / ((1.0 + p.rolling_inertia) * p.mass)}


MODEL = BallAndBeam()
