"""The paper's cases by their short names, and the runs that are made of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from master.reproduce.measures.runs import Run

from .tables import TABLES

HEXAPOD, LINEAR = "hexapod", "linear"
PLANTS = (HEXAPOD, LINEAR)

EXACT = ("compensator.identifier=fixed",)
LITERAL = ("compensator.preset=L",)
PREFILTER: tuple[str, ...] = ()
PRESETS = {"exact": EXACT, "F": PREFILTER, "L": LITERAL}


@dataclass(frozen=True)
class Case:
    """
    A table of the paper.

    `stops` is the variant that stops the divergence, `full` the one with everything on.
    """

    config: str
    title: str
    stops: str
    full: str


@dataclass(frozen=True)
class Known:
    """
    What is known of a case without a run (docs/bounds.md, phase), for the bounds.

    `frequency` [Hz] and `zeta0` of the real docking, `T_f` [s] of the sensor; `phase` [deg] and `magnitude`
    of each plant with 2 ms of dead time at that frequency.
    """

    frequency: float
    zeta0: float
    T_f: float
    phase: Mapping[str, float]
    magnitude: Mapping[str, float]

    def phase_of_force(self, plant: str, T_f: float) -> float:
        """Phase of the measured force [deg]: arg M - atan(w T_f)."""
        return self.phase[plant] - math.degrees(math.atan(2.0 * math.pi * self.frequency * T_f))

    def gain_error(self, plant: str, change: float) -> float:
        """Error eps of the identified G that changes zeta by so much: zeta = zeta0 + eps Im(1 - M)/2."""
        return 2.0 * change / (self.magnitude[plant] * math.sin(math.radians(-self.phase[plant])))


CASES = {
    "S1": Case("low_frequency", "Table 1, 0.97 Hz", "cfdc", "cfdc_dpdc"),
    "S2": Case("high_frequency", "Table 2, 2.6 Hz", "cfdc", "cfdc_dpdc"),
    "E1": Case("experiment", "Table 3, 0.43 Hz", "cfdc_fmdc", "all"),
    "E2": Case("experiment_1000kg", "Table 3, 0.87 Hz", "cfdc_fmdc", "all"),
}


def _of(hexapod: float, linear: float) -> Mapping[str, float]:
    return {HEXAPOD: hexapod, LINEAR: linear}


KNOWN = {
    "S1": Known(0.9746, 0.00486, TABLES["S1"].T_f, _of(-12.16, -12.39), _of(0.984, 0.995)),
    "S2": Known(2.617, 0.00822, TABLES["S2"].T_f, _of(-30.70, -33.20), _of(0.912, 0.965)),
    "E1": Known(0.4346, 0.00306, TABLES["E1"].T_f, _of(-5.45, -5.53), _of(0.997, 0.999)),
    "E2": Known(0.8749, 0.00619, TABLES["E2"].T_f, _of(-10.94, -11.13), _of(0.987, 0.996)),
}
SIMULATED, EXPERIMENTAL = ("S1", "S2"), ("E1", "E2")


def config_of(name: str, plant: str = HEXAPOD) -> str:
    """Return the configuration of a case's file with a plant."""
    return f"hexapod/{name}" if plant == HEXAPOD else name


def run_of(case: str, variant: str, values: tuple[str, ...] = (), plant: str = HEXAPOD) -> Run:
    """Return a run of a case."""
    return Run(config_of(CASES[case].config, plant), variant, values)
