"""Claims on forces, difference methods, poles, and the drag stage (Secs. III-C, V-A.2, V-A.4)."""

from __future__ import annotations

from collections.abc import Iterable

from master.reproduce.facts.cases import (
    CASES,
    EXACT,
    EXPERIMENTAL,
    HEXAPOD,
    KNOWN,
    LINEAR,
    PLANTS,
    SIMULATED,
    config_of,
    run_of,
)
from master.reproduce.measures.runs import Run

from .claim import CONDITION, FAILS, Check, Claim, around, below
from .loop import ATTENUATED, CRITERIA

METHODS = ("backward", "bilinear", "forward")
LONG = 60.0
PHASE_TOLERANCE = 1.5
LEAD_OF_A_RAMP = 0.01 * (1.546 - 1.0) * 0.1313  # v (alpha - 1) T_lead of S1 [m], docs/bounds.md


def method_run(case: str, method: str, stop_time: float | None = None) -> Run:
    """CFDC with the exact parameters of a difference method."""
    values = (*EXACT, f"compensator.difference_method={method}")
    return Run(CASES[case].config, CASES[case].stops, values, stop_time=stop_time)


def drag_run(variant: str, plant: str = HEXAPOD) -> Run:
    """Return a run of the drag stage."""
    return Run(config_of("drag", plant), variant)


_LAG = f"arg M - atan(w T_f), docs/bounds.md, phase; tolerance of a phase: {CRITERIA}"


def _forces() -> Iterable[Check]:
    for case in CASES:
        label = f"{case}: {CASES[case].title}, hexapod"
        none, stops = run_of(case, "none"), run_of(case, CASES[case].stops)
        lagging = around(KNOWN[case].phase_of_force(HEXAPOD, KNOWN[case].T_f), PHASE_TOLERANCE)
        yield Check(
            f"{case}.measured",
            f"{label}, no compensation",
            "f_mea_phase",
            (none,),
            lagging,
            "deg",
            bound_from=_LAG,
        )
        yield Check(
            f"{case}.compensated",
            f"{label}, compensated",
            "f_des_phase",
            (stops,),
            around(0.0, PHASE_TOLERANCE),
            "deg",
            bound_from=f"tolerance of a phase: {CRITERIA}",
            claim="The compensated force is in phase with the ideal one",
        )
    for case in EXPERIMENTAL:
        run = (run_of(case, "fmdc"),)
        label = f"{case}: {CASES[case].title}, hexapod, FMDC alone"
        lagging = around(KNOWN[case].phase_of_force(HEXAPOD, 0.0), PHASE_TOLERANCE)
        yield Check(f"{case}.fmdc", label, "f_des_phase", run, lagging, "deg", bound_from=_LAG)


def _fundamental() -> Iterable[Check]:
    for case in SIMULATED:
        for method in METHODS:
            label = f"{case}: {method}, exact parameters, linear, 10 s"
            run = (method_run(case, method),)
            yield Check(f"{case}.{method}.damping", label, "zeta_deviation", run, below(2e-4))
    for case in SIMULATED:
        for method in METHODS:
            values = (f"compensator.difference_method={method}",)
            run = (run_of(case, "cfdc_dpdc", values),)
            label = f"{case}: {method}, identified, hexapod, 10 s"
            why = ATTENUATED if case == "S2" else ""
            yield Check(f"{case}.{method}.rms", label, "rms_s_act", run, below(0.03), why=why)


def _second_mode() -> Iterable[Check]:
    bad = "forward: its exact parameters put a pole pair at the second mode outside the unit circle"
    for case in SIMULATED:
        for method in METHODS:
            fails = method == "forward"
            yield Check(
                f"{case}.{method}.pole",
                f"{case}: {method}, exact parameters, linear, fastest pole",
                "fastest_pole",
                (method_run(case, method),),
                below(0.0),
                "1/s",
                expected=FAILS if fails else None,
                why=bad if fails else "",
            )
    for method in METHODS:
        fails = method == "forward"
        yield Check(
            f"S2.{method}.60s",
            f"S2: {method}, exact parameters, linear, largest correction in the last of 60 s",
            "df_at_end",
            (method_run("S2", method, LONG),),
            below(0.9),
            "N",
            bound_from="0.9 N of docs/bounds.md, discretisation",
            expected=FAILS if fails else None,
            why=bad if fails else "",
        )


def _poles() -> Iterable[Check]:
    for case in CASES:
        run = run_of(case, CASES[case].stops, EXACT, LINEAR)
        label = f"{case}: linear, backward, exact"
        yield Check(f"{case}.dominant", label, "pole_deviation", (run,), below(5e-4))
        yield Check(
            f"{case}.simulated", f"{label}, zeta of pole and run", "zeta_of_pole", (run,), below(5e-4)
        )
    for plant, case in ((plant, case) for plant in PLANTS for case in CASES):
        run = run_of(case, CASES[case].stops, EXACT, plant)
        label = f"{case}: {plant}, backward, exact, poles of the motion simulator"
        source = "order of the backward difference: |s| T/2 of the pole"
        yield Check(f"{case}.cancel.{plant}", label, "cancellation", (run,), below(1.0), bound_from=source)
    for case in CASES:
        run = run_of(case, CASES[case].stops, EXACT)
        label = f"{case}: hexapod, backward, exact"
        yield Check(f"{case}.dominant.hexapod", label, "pole_deviation", (run,), below(5e-4))


def _drag() -> Iterable[Check]:
    why = (
        "K = 1/sqrt(alpha) undoes the lead's gain at its frequency and scales every ramp by "
        "0.80; K = 1 does not"
    )
    yield Check(
        "paper_gain",
        "DPDC with K = 1/sqrt(alpha), 100 mm of drag, hexapod",
        "offset_at_end",
        (drag_run("cfdc_dpdc"),),
        around(0.0, LEAD_OF_A_RAMP),
        "m",
        expected=FAILS,
        why=why,
    )
    for plant in PLANTS:
        run = (drag_run("unit_dc", plant),)
        label = f"DPDC with K = 1, 100 mm of drag, {plant}"
        yield Check(
            f"unit_gain.{plant}", label, "offset_at_end", run, around(0.0, LEAD_OF_A_RAMP), "m", why=why
        )


CLAIMS = (
    Claim(
        "forces",
        "Secs. V-A.1, V-A.3, V-B; Figs. 13, 16, 26, 28",
        "The force lags the ideal one without CFDC",
        "phase at the dynamics frequency against the force that the desired motion would make",
        tuple(_forces()),
        bound_from=CRITERIA,
    ),
    Claim(
        "three_differences",
        "Sec. V-A.2; Fig. 14",
        "Forward, backward and bilinear difference all prevent the divergence of the fundamental",
        "the three agree at the dynamics frequency; in a window of 10 s nothing else is seen",
        tuple(_fundamental()),
        if_met=CONDITION,
        bound_from=CRITERIA,
    ),
    Claim(
        "three_differences_long",
        "Sec. V-A.2; Fig. 14",
        "All three difference methods keep the whole system stable",
        "backward and bilinear difference map the second mode inside the unit circle",
        tuple(_second_mode()),
        bound_from=f"no pole with Re > 0: {CRITERIA}",
    ),
    Claim(
        "cfdc_cancels",
        "Sec. V-A.4; Figs. 21, 22",
        "With CFDC poles and zeros of the loop cancel and the rest is close to the ideal ones",
        "f_des = -G s_des whatever the motion simulator does; poles of the FMUs as they are stepped",
        tuple(_poles()),
        bound_from=CRITERIA,
    ),
    Claim(
        "drag",
        "Secs. III-C, IV-C",
        "DPDC reproduces the drag stage",
        "the lead with gain 1 at rest follows a ramp with its lag only",
        tuple(_drag()),
        if_met=CONDITION,
        bound_from="v (alpha - 1) T_lead, which a ramp is ahead by: Eq. 22, docs/bounds.md, drag",
    ),
)
