"""
Faults that belong to a compared channel rather than to the physics: zero, gain, delay, sign, size.

    measured - predicted = zero + (gain - 1) predicted - delay d(predicted)/dt

regressed on what a model leaves. A channel whose measurement goes against its prediction, or is of another
size, is told aloud whatever explains it best.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from master.diagnosis.adequacy.channels import Adequacy
from master.diagnosis.numerics.arrays import TINY, Array
from master.diagnosis.numerics.deviations import sandwich
from master.diagnosis.numerics.likeness import size_against

CERTAIN = 4.0  # deviations from none
WORTH = 0.1  # of the residual's power, that a fault has to explain
AGAINST = -0.5  # correlation with the prediction
LARGEST_SIZE = 8.0  # measured over predicted
LONGEST_DELAY = 0.05  # s
NEAR_BEST = 0.8  # of the share that the best regressor predicts
LATE_GAIN = 0.5  # of the residual's power, that another lag has to explain


@dataclass(frozen=True)
class ChannelFault:
    """A fault of a channel: `value` with its deviation, both in SI units, and the share that it explains."""

    signal: str
    kind: str
    value: float
    deviation: float
    share: float
    unit: str = ""

    def __str__(self) -> str:
        if self.kind == "sign":
            return f"channel {self.signal}: the other way round (correlation {self.value:.2f})"
        if self.kind == "size":
            return f"channel {self.signal}: {self.value:.4g} times the model"
        if self.kind == "delay":
            way = "late" if self.value > 0.0 else "early"
            return (
                f"channel {self.signal}: {1e3 * abs(self.value):.3g} +- {1e3 * self.deviation:.1g} ms {way}"
            )
        if self.kind == "error":
            return f"channel {self.signal}: what is left is {100.0 * self.value:.0f} % of what was measured"
        unit = f" {self.unit}" if self.unit else ""
        return f"channel {self.signal}: {self.kind} {self.value:.4g} +- {self.deviation:.2g}{unit}"


def channel_faults(
    signal: str, measured: Array, predicted: Array, period: float, unit: str = ""
) -> list[ChannelFault]:
    """
    Look for faults of one channel.

    Args:
        signal: Its name.
        measured: Shape (rows,).
        predicted: Shape (rows,).
        period: Of the rows [s].
        unit: Of the channel.
    """
    finite = np.isfinite(predicted)
    if finite.sum() < 10 or not np.any(np.ptp(measured[finite])):
        return []
    left = (measured - predicted)[finite]
    power = float(left @ left)
    if power == 0.0:
        return []
    found = [*_plausible(signal, measured[finite], predicted[finite])]
    if any(f.kind in ("sign", "size") for f in found):
        return found
    late = _lag(measured, predicted, period)
    if late is not None:
        ticks, share = late
        return [*found, ChannelFault(signal, "delay", ticks * period, 0.5 * period, share)]
    names = ("zero error", "gain error", "delay")
    units = (unit, "", "s")
    columns = _columns(predicted, period)[finite]
    for i, name in enumerate(names):
        column = columns[:, i : i + 1]
        size = float(column[:, 0] @ column[:, 0])
        if size <= TINY:
            continue
        value = float(column[:, 0] @ left) / size
        rest = left - value * column[:, 0]
        deviation = float(np.sqrt(max(sandwich(column, rest, 1, 0)[0, 0], 0.0)))
        share = 1.0 - float(rest @ rest) / power
        if share > WORTH and abs(value) > CERTAIN * deviation:
            found.append(ChannelFault(signal, name, value, deviation, share, units[i]))
    found.sort(key=lambda f: -f.share)
    return found[:1]


def is_best(fault: ChannelFault, channel: Adequacy) -> bool:
    """
    Whether a fault explains what is left about as well as anything does.

    What another law leaves has a part along the signal and along its rate, too: that is no gain and no delay.
    """
    return not channel.is_predictable or fault.share > NEAR_BEST * channel.share.value


def _plausible(signal: str, measured: Array, predicted: Array) -> list[ChannelFault]:
    """The other way round, another size, or an error larger than the signal."""
    a = measured - measured.mean()
    b = predicted - predicted.mean()
    norm = float(np.sqrt((a @ a) * (b @ b)))
    correlation = float(a @ b) / norm if norm > 0.0 else 0.0
    found = []
    if correlation < AGAINST:
        found.append(ChannelFault(signal, "sign", correlation, 0.0, 1.0))
    size = abs(size_against(measured, predicted))
    if not 1.0 / LARGEST_SIZE < size < LARGEST_SIZE:
        found.append(ChannelFault(signal, "size", size, 0.0, 1.0))
    rms = float(np.sqrt(np.mean(measured**2)))
    error = float(np.sqrt(np.mean((measured - predicted) ** 2))) / max(rms, TINY)
    if error > 1.0 and not found:
        found.append(ChannelFault(signal, "error", error, 0.0, 1.0))
    return found


def _columns(predicted: Array, period: float) -> Array:
    """What the factors of zero, gain and delay multiply, shape (rows, 3)."""
    filled = np.nan_to_num(predicted)
    return np.column_stack([np.ones(len(filled)), filled, -np.gradient(filled, period)])


def _lag(measured: Array, predicted: Array, period: float) -> tuple[int, float] | None:
    """Whole rows by which the channel is late, and the share that explains, where it explains most."""
    longest = min(round(LONGEST_DELAY / period), len(measured) // 20)
    base = float(np.nanmean((measured - predicted) ** 2))
    if longest < 1 or base <= 0.0:
        return None
    n = len(measured)
    best = 0
    least = base
    for ticks in (k for k in range(-longest, longest + 1) if k):
        own = measured[max(0, ticks) : n + min(0, ticks)]
        other = predicted[max(0, -ticks) : n - max(0, ticks)]
        power = float(np.nanmean((own - other) ** 2))
        if power < least:
            least = power
            best = ticks
    share = 1.0 - least / base
    return (best, share) if best and share > LATE_GAIN and abs(best) > 1 else None
