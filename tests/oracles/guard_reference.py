"""
Reference experiment of the guard, from whole arrays: its budget is looked up, not carried along.

A swing whose speed is known in closed form, v = V(t) cos(w t), first loses and then gains energy. What the
guard answers is put together afterwards: half cycles between the crossings, the budget of a half cycle from
those before.
"""

from __future__ import annotations

import numpy as np

from tests.oracles.reference_experiment import Experiment, time_grid

T = 1e-3
TIME = time_grid(250, T)
M_S, TOLERANCE, VARIATION, LEAST, REST = 900.0, 0.2, 0.05, 2e-3, 0.04
GAIN = (1.0 + TOLERANCE) * (1.0 + VARIATION) / (1.0 - VARIATION)
SLOW_LIMIT = 1.6
START_SHARE = 0.7
FORCE_NOISE = 40.0
HYSTERESIS = 0.1


def wave(values: np.ndarray) -> np.ndarray:
    """Round to few digits, so that a CSV holds them exactly."""
    return np.round(values, 9)


def budgets(speed: np.ndarray, start: float) -> tuple[np.ndarray, np.ndarray]:
    """Least budget at each instant, and the squared speed that is allowed then."""
    least, allowed = np.empty_like(speed), np.empty_like(speed)
    peaks: list[float] = []
    level = first = max(start, LEAST**2)
    begin, sign = 0, 0.0
    for k, u in enumerate(speed):
        recent = max(peaks[-2:]) if peaks else level
        least[k] = level
        of_start = (1.0 + TOLERANCE) * START_SHARE * first
        allowed[k] = max(GAIN * level, min(GAIN * recent, SLOW_LIMIT * level), of_start)
        crossed = np.sign(u) if abs(u) > HYSTERESIS * np.sqrt(level) else sign
        if sign and crossed != sign:
            peaks.append(float(np.max(speed[begin:k] ** 2)))
            begin = k
            if len(peaks) > 1:
                level = max(min(level, max(peaks[-2:])), LEAST**2)
        sign = crossed
    return least, allowed


def experiment() -> Experiment:
    """An oscillation of 20 Hz over a drag of 10 mm/s that decays, and grows from 0.13 s on."""
    w = 2.0 * np.pi * 20.0
    drag = 0.01
    envelope = 0.1 * np.exp(-4.0 * np.minimum(TIME, 0.13) + 8.0 * np.maximum(TIME - 0.13, 0.0))
    v_des = wave(drag + envelope * np.cos(w * TIME))
    s_des = wave(drag * TIME + envelope / w * np.sin(w * TIME) + 5e-4)
    x = wave(drag * TIME)
    inputs = {
        "s_des": s_des,
        "v_des": v_des,
        "s_act": wave(s_des - 2e-4),
        "f_mea": wave(-400.0 * np.cos(w * TIME)),
        "x": x,
        "v": np.full_like(TIME, drag),
        "f_comp": wave(-380.0 * np.sin(w * TIME)),
        "s_cmd": wave(s_des + 1e-3 * np.cos(w * TIME)),
    }
    parameters = {
        "m_s": M_S,
        "tolerance": TOLERANCE,
        "slow_limit": SLOW_LIMIT,
        "start_share": START_SHARE,
        "force_noise": FORCE_NOISE,
        "variation": VARIATION,
        "least_speed": LEAST,
        "rest_time": REST,
    }
    speed = inputs["v_des"] - drag
    force = abs(inputs["f_mea"][0]) + 3.0 * FORCE_NOISE
    least, allowed = budgets(speed, speed[0] ** 2 + force * abs(s_des[0] - x[0]) / M_S)
    ratio = speed**2 / least
    first = int(np.argmax(speed**2 > allowed))
    assert 130 < first < 240
    assert ratio[first] > 1.1 * GAIN
    after = np.arange(len(TIME)) >= first
    size = np.sqrt(allowed[first])
    rate = np.clip(speed[first], -size, size) * np.exp(-T / REST * np.arange(len(TIME)))
    s_safe = inputs["s_cmd"].copy()
    for i, k in enumerate(range(first, len(TIME))):
        s_safe[k] = inputs["s_cmd"][first - 1] + T * np.sum(rate[: i + 1])

    def after_a_step(rows: np.ndarray, start: float) -> np.ndarray:
        """Inputs of a row are answered in the next one."""
        return np.concatenate([[start], rows[:-1]])

    outputs = {
        "f_safe": after_a_step(np.where(after, 0.0, inputs["f_comp"]), inputs["f_comp"][0]),
        "s_safe": after_a_step(s_safe, inputs["s_cmd"][0]),
        "alarm": after_a_step(after.astype(float), 0.0),
        "reason": after_a_step(after.astype(float), 0.0),
        "energy_ratio": after_a_step(ratio, 0.0),
    }
    return Experiment("guard", TIME, parameters, inputs, outputs)
