"""
Answers of a linear system, sampled, to functions of time, from its answer to a step.

    y(k) = S_0 u(k) + sum over n >= 1 of (S_n - S_(n-1)) (u(k-n) + u(k-n+1))/2

with S the answer to a unit step at the first sample: u is linear between samples.
"""

from __future__ import annotations

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from .arrays import Array

CONSTANT = 1e-9  # of its first value: an answer that changes less has no memory


def convolved(step: Array, functions: Array) -> Array:
    """
    Answer of one output to functions of time.

    Args:
        step: Answer to a unit step, shape (samples,).
        functions: Shape (samples, m).

    Returns:
        Shape (samples, m).
    """
    n = len(step)
    later = np.diff(step)
    if np.abs(later).max() <= CONSTANT * abs(step[0]):
        return np.asarray(step[0] * functions)
    rows = np.ascontiguousarray(functions.T)  # transforms run along memory
    means = 0.5 * (rows[:, 1:] + rows[:, :-1])
    answers = step[0] * rows
    length = next_fast_len(2 * n - 3, real=True)
    spectrum = rfft(means, length)
    spectrum *= rfft(later, length)
    answers[:, 1:] += irfft(spectrum, length)[:, : n - 1]
    return np.ascontiguousarray(answers.T)
