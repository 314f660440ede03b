"""Figs. 21 and 22, and what the paper has no figure of: drag stage, stability maps (Secs. V-A.4, III-C)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from master.analysis.closed_loop.linearise import Linearisation
from master.analysis.measures.map_chart import map_chart
from master.analysis.measures.sweep import parse_axis, stability_map
from master.pages.chart import CIRCLE, CROSS, REFERENCE, Chart, Curve
from master.reproduce.claims.methods import drag_run
from master.reproduce.facts.cases import EXACT, LINEAR, run_of
from master.reproduce.measures.poles import Complexes, Plane, cancelled, planes
from master.reproduce.measures.runs import experiment_of

from .drawing import S_ACT, S_IDEAL, TIME, Recordings, curve
from .figure import Figure

_LOOP = run_of("S1", "cfdc", EXACT, LINEAR)
_REAL, _IMAGINARY = "real part [1/s]", "imaginary part [1/s]"
_NEAR, _WIDE = ((-8.0, 1.0), (-60.0, 60.0)), ((-1050.0, 60.0), (-90.0, 90.0))


def _marks(label: str, values: Complexes, style: str) -> Curve:
    return Curve(label, values.real, values.imag, style)


def _plane(marks: Sequence[Curve]) -> Sequence[Chart]:
    return [
        Chart(title, _REAL, _IMAGINARY, marks, y_range, x_range)
        for title, (x_range, y_range) in (("near the origin", _NEAR), ("all", _WIDE))
    ]


def _ideal(recordings: Recordings) -> Sequence[Chart]:
    ideal, _ = planes(experiment_of(_LOOP))
    return _plane([_marks("poles", ideal.poles, CROSS), _marks("zeros", ideal.zeros, CIRCLE)])


def _loop(recordings: Recordings) -> Sequence[Chart]:
    ideal, loop = planes(experiment_of(_LOOP))
    return _plane(
        [
            *_split(loop),
            _marks("poles of the ideal system", ideal.poles, CROSS),
            _marks("zeros of the ideal system", ideal.zeros, CIRCLE),
        ]
    )


def _split(loop: Plane) -> list[Curve]:
    gone_poles, gone_zeros = (np.array(flags, dtype=bool) for flags in cancelled(loop))
    return [
        _marks("poles that remain", loop.poles[~gone_poles], CROSS),
        _marks("zeros that remain", loop.zeros[~gone_zeros], CIRCLE),
        _marks("poles that cancel", loop.poles[gone_poles], CROSS),
        _marks("zeros that cancel", loop.zeros[gone_zeros], CIRCLE),
    ]


_DRAGS = (("K = 1/sqrt(alpha) (paper)", drag_run("cfdc_dpdc")), ("K = 1", drag_run("unit_dc")))


def _drag(recordings: Recordings) -> Sequence[Chart]:
    last = recordings[_DRAGS[-1][1]]
    motion = [curve("ideal", last, S_IDEAL, 1e3, REFERENCE)]
    motion += [curve(label, recordings[run], S_ACT, 1e3) for label, run in _DRAGS]
    error = [
        Curve(label, found.time, 1e3 * (found[S_ACT] - found[S_IDEAL]))
        for label, found in ((label, recordings[run]) for label, run in _DRAGS)
    ]
    return (
        Chart("displacement of the motion simulator", TIME, "displacement [mm]", motion),
        Chart("deviation from the ideal", TIME, "deviation [mm]", error),
    )


_STIFFNESS = "contact.k_m,compensator.k_m,ideal.k_m=50000:400000:15"
_DELAY = "compensator.f_mea=0:0.004"


@dataclass(frozen=True)
class _Map:
    """A map: title, axes as `dockloop analyse --sweep` takes them, label of the second one in ms."""

    title: str
    axes: tuple[str, ...]
    y_label: str = ""


_MAPS = (
    _Map(
        "delay that the measured force bears, by stiffness (S1, CFDC)",
        (_STIFFNESS, f"{_DELAY}:9"),
        "delay of f_mea [ms]",
    ),
    _Map(
        "sensor lag that the loop bears, by mass (S1, CFDC)",
        ("spacecraft.m_s=400:4000:10", "force_sensor.T_f=0:0.006:7"),
        "time constant T_f [ms]",
    ),
    _Map("delay of the measured force alone (S1, CFDC)", (f"{_DELAY}:21",)),
)


def _maps(recordings: Recordings) -> Sequence[Chart]:
    charts = []
    for one in _MAPS:
        linearisation = Linearisation(experiment_of(_LOOP))
        x, *more = (parse_axis(text, linearisation.system) for text in one.axes)
        found = stability_map(linearisation, x, more[0] if more else None)
        charts.append(map_chart(found, one.title, 1e3, one.y_label))
    return charts


FIGURES = (
    Figure(
        "21",
        "Poles and zeros of the ideal closed-loop system (S1)",
        "the poles (x) and zeros (o) of the real docking",
        "poles at -0.0298 +- 6.12j and -1.36 +- 48.1j, zeros (from the drag velocity to the "
        "spacecraft) at -948 "
        "and -583 1/s",
        {},
        _ideal,
    ),
    Figure(
        "22",
        "Poles and zeros of the closed loop with CFDC (S1, linear plant)",
        "some poles and zeros cancel, and those that remain are close to the ideal ones",
        "the same, from the FMUs as they are stepped: the poles of the motion simulator cancel to 0.03 %, "
        "the dominant pole is the ideal one to 0.001 %, and the second mode only nearly cancels, as the "
        "difference equation is right to the first order of the step",
        {},
        _loop,
    ),
)
EXTRA = (
    Figure(
        "drag",
        "Drag stage: 10 mm/s for 10 s, and the gain of DPDC (Table 1)",
        "Sec. III-C describes the stage; it has no figure, and Eq. 24 sets K = 1/sqrt(alpha)",
        "with that K the ramp comes out 19 % short; with K = 1 within 0.4 mm",
        {run: (S_ACT, S_IDEAL) for _, run in _DRAGS},
        _drag,
    ),
    Figure(
        "maps",
        "How much delay and lag the compensated loop bears",
        "the paper says that the compensation prevents divergence and gives no margin",
        "the margin is the damping of the contact: 1.6 ms in case S1, whatever the motion "
        "simulator; boundaries by "
        "root search on the poles of the stepped FMUs. Blue decays, orange grows, darker the faster; dashed "
        "lines have the damping ratio of the fastest pole; the circle is the case as it is",
        {},
        _maps,
    ),
)
