"""
Cells of random rigs for `dockloop compare-methods --cells`: what is not as believed, drawn at once.

    python benchmarks/draws.py 100 > draws.yaml
    dockloop compare-methods --cells draws.yaml --methods robust,qi,paper_F --seeds 1
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import yaml

N_DRAWS, SEED = 100, 1


def cell(rng: np.random.Generator) -> dict[str, Any]:
    """Draw stiffness, damping and lags that are believed wrong, noise, jitter and a rope that varies."""
    lag = rng.uniform(0.75, 1.35)
    sensor_lag = rng.uniform(0.7, 1.3)
    found: dict[str, Any] = {
        "prior": {
            "k": round(float(rng.uniform(0.7, 1.4)), 4),
            "lag": round(float(1.0 / lag), 4),
            "T_f": round(float(1.0 / sensor_lag), 4),
        },
        "set": {"force_sensor.sigma": round(float(10 ** rng.uniform(np.log10(0.03), np.log10(5.0))), 4)},
        "s_act_noise": round(float(rng.uniform(1e-6, 12e-6)), 9),
    }
    if rng.uniform() < 0.5:
        found["events"] = [{"at": 0, "jitter": {"compensator.f_mea": 1}}]
    if rng.uniform() < 1 / 3:
        share = round(float(rng.uniform(0.0, 0.15)), 4)
        found["set"] |= {f"{part}.k_p_amplitude": f"{share} contact.k_p" for part in ("contact", "ideal")}
    return found


def main() -> None:
    """Print a file of as many cells as asked for."""
    n = int(sys.argv[1]) if len(sys.argv) > 1 else N_DRAWS
    rng = np.random.default_rng(SEED)
    yaml.safe_dump({"cells": {f"draw {i + 1}": cell(rng) for i in range(n)}}, sys.stdout, sort_keys=False)


if __name__ == "__main__":
    main()
