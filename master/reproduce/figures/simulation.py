"""Figs. 10 to 16: the simulations with constant parameters (Secs. V-A.1 to V-A.3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from master.pages.chart import REFERENCE, Chart, Curve
from master.reproduce.claims.methods import LONG, METHODS, method_run
from master.reproduce.facts.cases import LITERAL, run_of
from master.reproduce.facts.tables import STEP, TABLES
from master.reproduce.measures.runs import Recording

from .drawing import (
    F_DES,
    F_IDEAL,
    F_MEA,
    PROCESS,
    S_ACT,
    S_IDEAL,
    TIME,
    Recordings,
    curve,
    displacement,
    forces,
    identification,
    title_of,
    variants_of,
)
from .figure import Figure

_ATTRIBUTES = ("m_e", "k_m", "c_m", "k_p", "c_p")
_IDENTIFIERS = (
    ("preset F (prefilter, good prior)", run_of("S1", "cfdc")),
    ("preset L (literal Kalman filter)", run_of("S1", "cfdc", LITERAL)),
)
_SIMULATED = ("none", "cfdc", "cfdc_dpdc")
_MOTIONS = (S_ACT, S_IDEAL)


def _attributes(recordings: Recordings) -> Sequence[Chart]:
    charts = []
    for label, run in _IDENTIFIERS:
        found = recordings[run]
        curves = [
            curve(n, found, f"compensator.{n}_id", 1.0 / getattr(TABLES["S1"].loop, n)) for n in _ATTRIBUTES
        ]
        curves.append(Curve("true value", found.time, np.ones_like(found.time), REFERENCE))
        charts.append(Chart(label, TIME, "recovered/true [1]", curves, (-1.0, 3.0)))
    return charts


_IDENTIFIED = [(m, run_of("S1", "cfdc_dpdc", (f"compensator.difference_method={m}",))) for m in METHODS]
_EXACT = [(m, method_run("S2", m, LONG)) for m in METHODS]


def _envelope(label: str, found: Recording) -> Curve:
    """Largest correction in each half second, as its logarithm."""
    n = round(0.5 / STEP)
    rows = found["compensator.df"][1:].reshape(-1, n)
    return Curve(label, found.time[n::n], np.log10(np.max(np.abs(rows), axis=1)))


def _differences(recordings: Recordings) -> Sequence[Chart]:
    motion, deviation = displacement(_IDENTIFIED, 12.0)(recordings)
    long = [_envelope(label, recordings[run]) for label, run in _EXACT]
    return (
        motion,
        Chart("deviation from the ideal", TIME, "deviation [mm]", deviation.curves, (-0.6, 0.6)),
        Chart(
            "S2, linear plant, exact parameters, 60 s: largest force correction in half a second",
            TIME,
            "log10 of |dF|/N",
            long,
        ),
    )


FIGURES = (
    Figure(
        "10",
        f"Displacements with different compensation methods ({title_of('S1')})",
        "without compensation the motion diverges; CFDC stops that and leaves a small phase lag; CFDC+DPDC "
        "basically coincides with the ideal curve",
        "the same; the growth is 1.90 a cycle (linear plant 1.93), the lag 12 deg, and 0.3 "
        "deg remain with DPDC",
        {run: _MOTIONS for _, run in variants_of("S1", _SIMULATED)},
        displacement(variants_of("S1", _SIMULATED), 30.0),
    ),
    Figure(
        "11",
        "Identification of the process parameters (S1)",
        "the five process parameters come out accurately in noise",
        "with preset F c, d, e stay at 0.95 of the theory, where the prior put them: what "
        "looks accurate is the "
        "prior. The literal filter (L) finds the same response with parameters that are far off",
        {run: PROCESS for _, run in _IDENTIFIERS},
        identification("S1", _IDENTIFIERS),
    ),
    Figure(
        "12",
        "Attribute parameters calculated from the process parameters (S1)",
        "seriously distorted, some negative: singular",
        "the same with L, where nearly every row is distorted; with F one sees the prior through Eq. 16",
        {run: tuple(f"compensator.{n}_id" for n in _ATTRIBUTES) for _, run in _IDENTIFIERS},
        _attributes,
    ),
    Figure(
        "13",
        f"Contact forces ({title_of('S1')})",
        "the measured force lags without compensation; the compensated force has nearly the ideal phase",
        "the same: -12.2 deg against -0.35 deg, of which one step is in the recording",
        {run_of("S1", "none"): (F_MEA,), run_of("S1", "cfdc"): (F_DES, F_IDEAL)},
        forces(
            run_of("S1", "cfdc"),
            [
                ("measured, no compensation", run_of("S1", "none"), F_MEA),
                ("compensated, CFDC", run_of("S1", "cfdc"), F_DES),
            ],
            900.0,
            3.0,
        ),
    ),
    Figure(
        "14",
        "CFDC+DPDC with three difference methods (S1); and what 60 s show (S2)",
        "all three prevent the divergence, with high accuracy",
        "all three look alike for 10 s. The exact parameters of the forward difference make "
        "the second mode grow: "
        "after 60 s the correction reaches 22 kN against 0.5 N with the other two",
        {
            **{run: _MOTIONS for _, run in _IDENTIFIED},
            **{run: ("compensator.df",) for _, run in _EXACT},
        },
        _differences,
    ),
    Figure(
        "15",
        f"Displacements with different compensation methods ({title_of('S2')})",
        "the divergence is faster; CFDC stops it, with visible delay and attenuation; "
        "CFDC+DPDC gives the ideal "
        "result",
        "the same, if DPDC undoes the hexapod's attenuation to 0.90 too: an error of 1.0 % rms, 4.0 % with "
        "the paper's K (linear plant: 1.6 %)",
        {run: _MOTIONS for _, run in variants_of("S2", _SIMULATED)},
        displacement(variants_of("S2", _SIMULATED), 30.0),
    ),
    Figure(
        "16",
        f"Contact forces ({title_of('S2')})",
        "the measured force has a large delay and diverges rapidly; the compensated force is "
        "close to the ideal",
        "the same: -30 deg against -0.94 deg, of which one step is in the recording",
        {run_of("S2", "none"): (F_MEA,), run_of("S2", "cfdc"): (F_DES, F_IDEAL)},
        forces(
            run_of("S2", "cfdc"),
            [
                ("measured, no compensation", run_of("S2", "none"), F_MEA),
                ("compensated, CFDC", run_of("S2", "cfdc"), F_DES),
            ],
            8000.0,
            1.5,
        ),
    ),
)
