"""What the inputs of a rig are during a step, for the master's delay ledger."""

from __future__ import annotations

from ..framework.model import Delay, InputHold
from ..framework.variables import Variable, choice

_STEPS = {"interpolate": 0.0, "hold_new": -0.5, "hold_old": 0.5}


def input_hold() -> Variable:
    """Return the choice that every rig has."""
    return choice("input_hold", InputHold.interpolate, "What the inputs are during a step")


def held(*inputs: str) -> tuple[Delay, ...]:
    """Return the half steps of delay that the choice means for inputs."""
    return tuple(
        Delay(name, "hold", steps=_STEPS, by="input_hold", reason="the input during a step")
        for name in inputs
    )
