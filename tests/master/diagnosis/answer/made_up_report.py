"""The report of a diagnosis that nobody had to make, as `report.json` holds it."""

from __future__ import annotations

from typing import Any

UNITS = {"axis.force": "N", "axis.friction_coulomb_level": "N"}
STATUS = {"status": "traced", "why": "", "sealed_gain": 0.75, "sealed_gain_interval": [0.7, 0.8]}
CHANNEL = {
    "noise_floor": 0.9,
    "evidence": "rest",
    "stages": [
        {
            "model": "refit",
            "rms": 2.0,
            "over_floor": 2.22,
            "predictable_share": 0.7,
            "interval": [0.6, 0.8],
            "predictors": [{"what": "a law of velocity", "share": 0.7, "interval": [0.6, 0.8]}],
        }
    ],
}


def error(rmse):
    return {
        "rmse": rmse,
        "nrmse_percent": 10.0 * rmse,
        "max": 2.0,
        "energy": 1.0,
        "rmse_interval": [0.9, 1.1],
    }


def made_up_report() -> dict[str, Any]:
    fitted = {"nominal": None, "refitted": None, "deviation_refitted": None}
    fitted |= {"with_effect": 20.5, "deviation": 0.12, "at_bound": False, "no_number": ""}
    return {
        "name": "a <case>",
        "verdict": "traced",
        "sentence": "Traced: axis.friction: coulomb.",
        "effects": [
            {"fmu": "axis", "slot": "friction", "effect": "coulomb", "parameters": {"level": 20.5}} | STATUS
        ],
        "subsystem": "axis",
        "nominal": {"axis.force": error(4.0)},
        "before": {"axis.force": error(2.0)},
        "after": {"axis.force": error(1.0)},
        "explained_share": 0.75,
        "undistinguished": [{"family": ["coulomb", "dahl"], "experiment": "Record slowly."}],
        "runners_up": [{"round": 1, "effect": "axis.friction: dahl", "gain": 0.5, "why": "explains less"}],
        "parameters": {"axis.friction_coulomb_level": fitted},
        "recordings": {"run": {"rows": 4000, "period": 0.001, "notes": ["gaps: 1"]}},
        "residual": {"axis": {"exact": True}},
        "channels": {"axis.force": CHANNEL},
        "files": ["report.json"],
    }
