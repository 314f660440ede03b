"""
Extrapolation of a connection: the value one step of its target on.

    order 1: 2 u0 - u1          order 2: 3 u0 - 3 u1 + u2

u0 is the present value, u1 and u2 those that the target got in its steps before: the polynomial of that order
through the last values. It is a rule of a wire: the stepping loop compiles it, the linear analysis for
rows of coefficients.
"""

from __future__ import annotations

from typing import Any

HOLD = 0


def one_step_on(order: int, value: Any, last: Any, before: Any) -> Any:
    """Extrapolate to the end of a step; order 1 does not read `before`."""
    if order == 1:
        return 2.0 * value - last
    return 3.0 * value - 3.0 * last + before


def gained_steps(order: int) -> int:
    """Steps of the target by which a smooth signal is younger."""
    return 0 if order == HOLD else 1


def reason(order: int) -> str:
    """Say in the ledger why."""
    return f"polynomial of order {order} through the last values"


def faults(wires: list[str], where: str) -> list[str]:
    """What is wrong with extrapolated connections that an iteration closes."""
    return [f"{where}: an iterated connection is not extrapolated, got {wire}" for wire in wires]
