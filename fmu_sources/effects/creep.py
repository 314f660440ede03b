"""
Creep of a sensor: under a load that stays, the reading creeps on (Prony series of four arms).

    y = value + sum c_i (z_i - value),   z_i' = (value - z_i) / tau_i,   c_i = share_i

tau_i lie evenly on a logarithmic scale from the shortest to the longest. The final value is the true one; a
series that starts from the quick reading has the same arms and another gain, which a sensor cannot show of
itself. At the start the creep is at rest.

Parameters share_1 to share_4 [1], shortest, longest [s] > 0
Source     Prony series of linear viscoelasticity; Tschoegl, The Phenomenological Theory of Linear
           Viscoelastic Behavior (1989), Ch. 3. Creep of load cells: OIML R 60.
Limits     With one arm a lag of a share of the value; time constants far beyond the recording are a gain.
"""

from __future__ import annotations

from typing import Any

from ..framework.arithmetic import Arithmetic
from ..framework.variables import parameter, state
from .framework.effect import SIGNAL, Applied, Effect
from .framework.experiment import Experiment

ARMS = (1, 2, 3, 4)


def law(t: Any, value: Any, s: Any, x: Any, p: Any, m: Arithmetic) -> Applied:
    """Let shares of the value come late."""
    ratio = p.longest / p.shortest
    steps = [i / (len(ARMS) - 1) for i in range(len(ARMS))]
    times = [p.shortest * m.exp(step * m.log(ratio)) for step in steps]
    behind = [getattr(x, f"crept_{i}") - value for i in ARMS]
    added = sum(getattr(p, f"share_{i}") * b for i, b in zip(ARMS, behind, strict=True))
    rates = {f"crept_{i}": -b / tau for i, b, tau in zip(ARMS, behind, times, strict=True)}
    return Applied(value + added, rates)


EFFECT = Effect(
    name="creep",
    description="A reading that creeps under a load that stays",
    law=law,
    parameters=(
        *(parameter(f"share_{i}", 0.0, "1", f"Share of arm {i}", minimum=-2.0, maximum=2.0) for i in ARMS),
        parameter("shortest", 0.1, "s", "Shortest time constant", above=0.0),
        parameter("longest", 10.0, "s", "Longest time constant", above=0.0),
    ),
    states=tuple(state(f"crept_{i}", "{value}", f"Value behind arm {i} z_{i}") for i in ARMS),
    absent={f"share_{i}": 0.0 for i in ARMS},
    scale=lambda rms: {
        **{f"share_{i}": 0.1 for i in ARMS},
        "shortest": 5e-3 * rms.duration,
        "longest": rms.duration,
    },
    places=SIGNAL,
    follows=tuple(f"crept_{i}" for i in ARMS),
    shown_by=(Experiment.LONG_REST,),
    of_class="creep",
)
