"""
Dormand-Prince of order 8 with error estimates of orders 5 and 3 and step control, compiled.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, Sec. II.10; coefficients: SciPy.
"""

from __future__ import annotations

import numba
import numpy as np
from scipy.integrate import DOP853

from .plant import derivatives

STAGES = 12
A, B, C = (np.ascontiguousarray(values) for values in (DOP853.A, DOP853.B, DOP853.C))
E3, E5 = DOP853.E3.copy(), DOP853.E5.copy()
RELATIVE, ABSOLUTE = 1e-9, 1e-12


@numba.njit(cache=True)
def advance(t, end, y, command, p, e, h):
    """Take the states y from t to end [s] in place; give the step size [s] for the next call."""
    n = len(y)
    k = np.empty((STAGES + 1, n))
    stage, new = np.empty(n), np.empty(n)
    while t < end:
        last = h >= end - t
        step = end - t if last else h
        derivatives(t, y, command, p, e, k[0])
        for i in range(1, STAGES):
            for j in range(n):
                total = 0.0
                for m in range(i):
                    total += A[i, m] * k[m, j]
                stage[j] = y[j] + step * total
            derivatives(t + C[i] * step, stage, command, p, e, k[i])
        for j in range(n):
            total = 0.0
            for m in range(STAGES):
                total += B[m] * k[m, j]
            new[j] = y[j] + step * total
        derivatives(t + step, new, command, p, e, k[STAGES])
        error = norm(k, y, new, step)
        factor = 5.0 if error == 0.0 else min(5.0, max(0.2, 0.9 * error ** (-1.0 / 8.0)))
        if error <= 1.0 or step < 1e-9:
            y[:] = new
            t = end if last else t + step
            h = max(h, step * factor) if last else step * factor
        else:
            h = step * factor
    return h


@numba.njit(cache=True)
def norm(k, y, new, step):
    """Error over tolerance; 1 is the limit."""
    n, sum5, sum3 = len(y), 0.0, 0.0
    for j in range(n):
        scale = ABSOLUTE + RELATIVE * max(abs(y[j]), abs(new[j]))
        error5 = error3 = 0.0
        for i in range(STAGES + 1):
            error5 += E5[i] * k[i, j]
            error3 += E3[i] * k[i, j]
        sum5 += (error5 / scale) ** 2
        sum3 += (error3 / scale) ** 2
    if sum5 == 0.0 and sum3 == 0.0:
        return 0.0
    return abs(step) * sum5 / np.sqrt((sum5 + 0.01 * sum3) * n)
