"""
Write the recording of first_case.yaml: a servo axis in closed form, with friction the model lacks.

    q = sum A_i sin(w_i t + p_i),  force = M q'' + c q' + F_c sign(q') + noise

    python -m tests.rig.first_case [PATH]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

DEFAULT = Path(__file__).parents[2] / "configs" / "measured" / "recordings" / "first_case.csv"
PERIOD = 0.004  # s
N_ROWS = 4000
MASS, DAMPING, FRICTION = 96.0, 210.0, 20.0  # kg, N s/m, N
NOISE, SEED = 0.5, 1  # N
TONES = ((0.03, 0.25, 0.0), (0.012, 0.75, 1.0), (0.004, 1.75, 2.0))  # m, Hz, rad


def columns() -> dict[str, np.ndarray]:
    """Columns of the recording by their names, shape (rows,), SI units."""
    t = PERIOD * np.arange(N_ROWS)
    phases = [(a, 2 * np.pi * f, 2 * np.pi * f * t + p) for a, f, p in TONES]
    q = sum(a * np.sin(phase) for a, _, phase in phases)
    v = sum(a * w * np.cos(phase) for a, w, phase in phases)
    acceleration = sum(-a * w * w * np.sin(phase) for a, w, phase in phases)
    noise = NOISE * np.random.default_rng(SEED).standard_normal(N_ROWS)
    force = MASS * acceleration + DAMPING * v + FRICTION * np.sign(v) + noise
    return {"t": t, "q": q, "v": v, "a": acceleration, "force": force}


def write(path: Path) -> None:
    """Write the recording as CSV."""
    found = columns()
    rows = np.column_stack(list(found.values()))
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savetxt(path, rows, delimiter=",", header=",".join(found), comments="", fmt="%.8g")


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else DEFAULT)
