"""The operations of the stepping loop that have a rule of their own: extrapolation, channels, iteration."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from .program import DELAY, DROP, FALLBACK, FREEZE, HELD, JITTER, MODE, OFFSET, RANDOM, Memory

Floats = NDArray[np.float64]

_MULTIPLIER, _MODULUS = 48271, 2147483647


@register_jitable
def extrapolate(rings: Floats, first: int, order: int, value: float) -> Any:
    """
    Value one step on, by the polynomial through the present and the `order` last values.

        order 1: 2 u0 - u1          order 2: 3 u0 - 3 u1 + u2
    """
    last = rings[first]
    rings[first] = value
    if order == 1:
        return 2.0 * value - last
    before = rings[first + 1]
    rings[first + 1] = last
    return 3.0 * value - 3.0 * last + before


@register_jitable
def channel(row: Floats, rings: Floats, first: int, n: int, k: int, value: float) -> Any:
    """
    Pass a value through a connection under a scenario: delay, jitter, offset, freeze, drop.

    Jitter adds 0 to `JITTER` ticks, drawn by the generator of Park and Miller (minimal standard,
    multiplier 48271, Comm. ACM 36 (1993) 105-110) whose state stands in the row.
    """
    rings[first + k % n] = value
    age = np.int64(row[DELAY])
    if row[JITTER] > 0.0:
        state = (_MULTIPLIER * np.int64(row[RANDOM])) % _MODULUS
        row[RANDOM] = state
        age += state % (np.int64(row[JITTER]) + 1)
    if row[MODE] == FREEZE:
        return row[HELD]
    if row[MODE] == DROP:
        return row[FALLBACK]
    row[HELD] = rings[first + (k - age) % n] + row[OFFSET]
    return row[HELD]


@register_jitable
def close_loop(memory: Memory, loop: int) -> tuple[int, int]:
    """
    Decide after a pass over an iterated group whether its wires agree.

    Returns:
        Operation to go back to, or -1 if all agree; row of the worst wire if the passes are used up, else -1.
    """
    back, first, end, most, passes = memory.loops[loop]
    worst, largest = -1, 1.0
    for j in range(first, end):
        source, target, c = memory.residuals[j]
        sent = memory.conversions[c, 0] * memory.values[source] + memory.conversions[c, 1]
        ratio = abs(sent - memory.values[target]) / memory.tolerances[j]
        if not (ratio <= largest):
            worst, largest = j, ratio
    if worst < 0:
        memory.loops[loop, 4] = 0
        return -1, -1
    memory.loops[loop, 4] = passes + 1
    if passes + 1 >= most:
        memory.loops[loop, 4] = 0
        return -1, worst
    return back, -1
