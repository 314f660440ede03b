"""What the drawing functions of several figures share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from master.pages.chart import DOTTED, LINE, REFERENCE, Chart, Curve
from master.reproduce.facts.cases import CASES, HEXAPOD, run_of
from master.reproduce.facts.tables import STEP, STIFFNESS_FREQUENCY, TABLES
from master.reproduce.measures import contact
from master.reproduce.measures.runs import Recording, Run

Floats = NDArray[np.float64]
Recordings = Mapping[Run, Recording]
Draw = Callable[[Recordings], Sequence[Chart]]
Labelled = Sequence[tuple[str, Run]]

TIME = "time [s]"
S_ACT, S_IDEAL = "motion_simulator.s_act", "ideal.s"
F_MEA, F_DES, F_IDEAL = "force_sensor.f_mea", "compensator.f_des", "ideal.f"
PROCESS = tuple(f"compensator.{name}" for name in "abcde")

LABELS = {
    "none": "no compensation",
    "dpdc": "DPDC",
    "fmdc": "FMDC",
    "cfdc": "CFDC",
    "cfdc_dpdc": "CFDC+DPDC",
    "cfdc_fmdc": "CFDC+FMDC",
    "all": "CFDC+FMDC+DPDC",
}


def variants_of(case: str, variants: Sequence[str], plant: str = HEXAPOD) -> Labelled:
    """Return the runs of a case with the paper's names of the variants."""
    return [(LABELS[v], run_of(case, v, plant=plant)) for v in variants]


def curve(label: str, recording: Recording, signal: str, scale: float = 1.0, style: str = LINE) -> Curve:
    """Return a signal over time."""
    return Curve(label, recording.time, scale * recording[signal], style)


def displacement(runs: Labelled, limit: float, title: str = "displacement of the motion simulator") -> Draw:
    """Draw s_act of each run against the ideal motion, and their deviation from it [mm]."""

    def draw(recordings: Recordings) -> Sequence[Chart]:
        last = recordings[runs[-1][1]]
        motion = [curve("ideal", last, S_IDEAL, 1e3, REFERENCE)]
        deviation = []
        for label, run in runs:
            found = recordings[run]
            motion.append(curve(label, found, S_ACT, 1e3))
            deviation.append(Curve(label, found.time, 1e3 * (found[S_ACT] - found[S_IDEAL])))
        return (
            Chart(title, TIME, "displacement [mm]", motion, (-limit, limit)),
            Chart("deviation from the ideal", TIME, "deviation [mm]", deviation, (-0.5 * limit, 0.5 * limit)),
        )

    return draw


def forces(ideal: Run, drawn: Sequence[tuple[str, Run, str]], limit: float, until: float) -> Draw:
    """Draw forces of runs against the ideal force [N]; the second panel shows the first seconds."""

    def draw(recordings: Recordings) -> Sequence[Chart]:
        curves = [curve("ideal force", recordings[ideal], F_IDEAL, 1.0, REFERENCE)]
        curves += [curve(label, recordings[run], signal) for label, run, signal in drawn]
        bounds = (-limit, limit)
        return (
            Chart("contact force", TIME, "force [N]", curves, bounds),
            Chart(f"the same, first {until:g} s", TIME, "force [N]", curves, bounds, (0.0, until)),
        )

    return draw


def theory(case: str, time: Floats, name: str, amplitude: float = 0.0) -> Curve:
    """Return a theoretical process parameter; `amplitude` [N/m] is that of a stiffness that varies."""
    loop = TABLES[case].loop
    k_p = loop.k_p + amplitude * np.sin(2.0 * np.pi * STIFFNESS_FREQUENCY * time)
    values = contact.process_parameters(loop, STEP, k_p)[:, "abcde".index(name)]
    return Curve(f"{name}, theory", time, values, DOTTED, like=name)


def identification(case: str, runs: Labelled) -> Draw:
    """Draw a, b and c, d, e of each run over the theoretical values."""

    def draw(recordings: Recordings) -> Sequence[Chart]:
        charts = []
        for label, run in runs:
            found = recordings[run]
            for names, unit in (("ab", "1"), ("cde", "N/m")):
                curves = [curve(n, found, f"compensator.{n}") for n in names]
                curves += [theory(case, found.time, n) for n in names]
                charts.append(Chart(f"{', '.join(names)}: {label}", TIME, f"parameter [{unit}]", curves))
        return charts

    return draw


def title_of(case: str) -> str:
    """Return the case's name for a heading."""
    return f"{case}, {CASES[case].title}"
