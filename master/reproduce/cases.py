"""The paper's cases by their short names, and the runs that are made of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .runs import Run

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

    `stops` is the variant that stops the divergence, `full` the one with everything on. `phase` is the
    response of each plant with 2 ms of dead time at the dynamics frequency [deg].
    """

    config: str
    title: str
    stops: str
    full: str
    phase: Mapping[str, float]


CASES = {
    "S1": Case("low_frequency", "Table 1, 0.97 Hz", "cfdc", "cfdc_dpdc", {HEXAPOD: -12.16, LINEAR: -12.39}),
    "S2": Case("high_frequency", "Table 2, 2.6 Hz", "cfdc", "cfdc_dpdc", {HEXAPOD: -30.70, LINEAR: -33.20}),
    "E1": Case("experiment", "Table 3, 0.43 Hz", "cfdc_fmdc", "all", {HEXAPOD: -5.45, LINEAR: -5.53}),
    "E2": Case(
        "experiment_1000kg", "Table 3, 0.87 Hz", "cfdc_fmdc", "all", {HEXAPOD: -10.94, LINEAR: -11.13}
    ),
}
SIMULATED, EXPERIMENTAL = ("S1", "S2"), ("E1", "E2")


def config_of(name: str, plant: str = HEXAPOD) -> str:
    """Give the configuration of a case's file with a plant."""
    return f"hexapod/{name}" if plant == HEXAPOD else name


def run_of(case: str, variant: str, values: tuple[str, ...] = (), plant: str = HEXAPOD) -> Run:
    """Give a run of a case."""
    return Run(config_of(CASES[case].config, plant), variant, values)
