"""All that `dockloop analyse` says of a system."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from master.analysis.closed_loop.along_a_run import LinearityAlongRun, linearity_along_run
from master.analysis.closed_loop.linearise import Assumption, Linearisation
from master.analysis.closed_loop.tick_matrix import LinearSystem
from master.analysis.measures.margins import Margin, margins
from master.analysis.measures.poles import Pole, dominant, growth_rate, nearest, poles
from master.evaluation.modes import Mode
from master.experiment.experiment import Experiment
from master.stepping.simulate import SlaveFactory, load

SHOWN_MISFIT = 1e-5
SHOWN_CURVATURE = 1e-3


@dataclass(frozen=True)
class Analysis:
    """
    Poles, margins, and what the linear system rests on.

    Of a system that varies with time (`along`) `dominant`, `reference` and `growth_rate` are those along its
    run, poles and margins those under the assumptions.
    """

    coupled: LinearSystem
    assumptions: tuple[Assumption, ...]
    poles: tuple[Pole, ...]
    dominant: Pole | None
    reference: Pole | None
    growth_rate: float
    margins: tuple[Margin, ...]
    along: LinearityAlongRun | None = None

    @property
    def stable(self) -> bool:
        """Whether no pole is outside the unit circle."""
        return self.growth_rate <= 0.0

    @property
    def latency_budget(self) -> Margin | None:
        """Connection of the force path that bears the least delay."""
        forces = [w.target.name for w in self.coupled.wires if w.target.variable.unit_name == "N"]
        bounded = [m for m in self.margins if m.target in forces and m.delay is not None]
        return min(bounded, key=lambda m: m.delay or 0.0, default=None)

    @property
    def notes(self) -> list[str]:
        """Objections to the linear system."""
        found = []
        for name, part in self.coupled.parts.items():
            if part.system.curvature > SHOWN_CURVATURE:
                found.append(f"{name}: not linear, the answers bend by {part.system.curvature:.1e}")
            if part.system.misfit > SHOWN_MISFIT:
                found.append(f"{name}: its answers are repeated to {part.system.misfit:.1e} only")
        if self.coupled.period != 1:
            found.append("FMUs of several rates: no margins")
        return found + ([] if self.along is None else _along_notes(self.along))

    def as_dict(self) -> dict[str, Any]:
        """Fields for JSON."""
        budget = self.latency_budget
        return {
            "stable": self.stable,
            "growth_rate": self.growth_rate,
            "dominant": None if self.dominant is None else pole_dict(self.dominant),
            "reference": None if self.reference is None else pole_dict(self.reference),
            "latency_budget": None if budget is None else {"to": budget.target, "seconds": budget.delay},
            "poles": [pole_dict(p) for p in self.poles],
            "margins": [_margin_dict(m) for m in self.margins],
            "fmus": {
                name: {"order": p.system.order, "misfit": p.system.misfit, "curvature": p.system.curvature}
                for name, p in self.coupled.parts.items()
            },
            "along_run": None if self.along is None else _along_dict(self.along),
            "assumptions": [vars(a) for a in self.assumptions],
            "notes": self.notes,
        }


def analyse(experiment: Experiment, factory: SlaveFactory = load) -> Analysis:
    """
    Linearise, couple and judge a system.

    Raises:
        FmuError: If an FMU fails, or cannot save its state.
    """
    linearisation = Linearisation(experiment, factory, after_run=True)
    return judge(linearisation.coupled(), linearisation)


def judge(coupled: LinearSystem, linearisation: Linearisation) -> Analysis:
    """
    Find poles and margins of a coupled system.

    Raises:
        FmuError: If an FMU fails in a run, or cannot save its state.
    """
    compare = linearisation.experiment.compare_in_fmus
    signal = None if compare is None else compare.signal
    found = poles(coupled, signal, linearisation.experiment.duration)
    best = dominant(found)
    reference = None
    if compare is not None and compare.reference is not None and best is not None:
        name = compare.reference.instance
        period = coupled.step_size * coupled.schedule.every[name]
        reference = nearest(coupled.parts[name].system, period, best)
    frozen = Analysis(
        coupled=coupled,
        assumptions=linearisation.assumptions,
        poles=tuple(found),
        dominant=best,
        reference=reference,
        growth_rate=growth_rate(coupled),
        margins=tuple(margins(coupled)),
    )
    found_along = linearity_along_run(linearisation, coupled) if linearisation.after_run else None
    return _along_its_run(frozen, found_along)


def _along_its_run(frozen: Analysis, found: LinearityAlongRun | None) -> Analysis:
    if found is None:
        return frozen
    step = frozen.coupled.step_size
    return replace(
        frozen,
        along=found,
        dominant=_shown(found.mode, step, frozen.dominant),
        reference=_shown(found.reference, step, frozen.reference),
        growth_rate=found.growths[-1] if found.growths else frozen.growth_rate,
    )


def _shown(mode: Mode | None, step: float, frozen: Pole | None) -> Pole | None:
    """Return a mode of a motion as a pole of one tick; the FMUs that participate are the frozen one's."""
    if mode is None:
        return None
    return Pole(cmath.exp(mode.pole * step), step, () if frozen is None else frozen.parts)


def _along_notes(found: LinearityAlongRun) -> list[str]:
    notes = [
        "the system varies with time: zeta of the dominant pole and of the reference is what the linear "
        f"system shows from {found.begin:g} to {found.end:g} s; "
        "poles and margins are those under the assumptions"
    ]
    if not found.growths:
        notes.append("no whole period in the run: the growth, too, is that under the assumptions")
    if found.learners:
        least, most = min(found.growths, default=0.0), max(found.growths, default=0.0)
        notes.append(
            f"{', '.join(found.learners)}: learning goes on, and depends on the run and its noise; over "
            f"single periods the growth is from {least:+.4g} to {most:+.4g} 1/s, above that of the last"
        )
    if found.nonlinear is not None and found.simulated is not None:
        name, share = found.nonlinear
        notes.append(
            f"not linear in this run: {name} departs by {100 * share:.2g} % of its largest output, the "
            f"motion by {100 * found.departure:.2g} %; zeta of the run itself is {found.simulated.zeta:+.6f}"
        )
    return notes


def _along_dict(found: LinearityAlongRun) -> dict[str, Any]:
    modes = {"linear": found.mode, "reference": found.reference, "run": found.simulated}
    return {
        "begin": found.begin,
        "end": found.end,
        "period": found.period,
        "growth_rates": list(found.growths),
        "departure": found.departure,
        "nonlinear": None if found.nonlinear is None else dict([found.nonlinear]),
        "learning": list(found.learners),
        "zeta": {name: None if mode is None else mode.zeta for name, mode in modes.items()},
    }


def pole_dict(pole: Pole) -> dict[str, Any]:
    """Fields of a pole for JSON."""
    return {
        "z": [pole.z.real, pole.z.imag],
        "s": [pole.s.real, pole.s.imag],
        "frequency": pole.frequency,
        "zeta": pole.zeta,
        "growth_per_cycle": pole.growth_per_cycle,
        "parts": dict(pole.parts),
    }


def _margin_dict(margin: Margin) -> dict[str, Any]:
    return {
        "from": margin.source,
        "to": margin.target,
        "delay": margin.delay,
        "frequency": margin.frequency,
        "gain_up": margin.gain_up,
        "gain_down": margin.gain_down,
    }


def lines(analysis: Analysis) -> list[str]:
    """Analysis for a terminal."""
    return [
        *_head(analysis),
        *_pole_lines(analysis.poles),
        *_margin_lines(analysis.margins),
        *_tail(analysis),
    ]


def _head(analysis: Analysis) -> list[str]:
    verdict = "stable" if analysis.stable else "unstable"
    found = [f"{verdict}: the largest growth of a pole is {analysis.growth_rate:+.5g} 1/s"]
    for name, pole in (("dominant pole", analysis.dominant), ("reference", analysis.reference)):
        if pole is not None:
            found.append(f"  {name:<16}zeta {pole.zeta:+.6f} at {pole.frequency:.5f} Hz")
    budget = analysis.latency_budget
    if budget is not None and budget.delay is not None:
        found.append(
            f"  {'latency budget':<16}{1e3 * budget.delay:.3f} ms on {budget.source} -> {budget.target}"
        )
    return found


def _pole_lines(found: Sequence[Pole]) -> list[str]:
    rows = ["", f"  {'f [Hz]':>10}{'zeta':>12}{'growth':>10}{'decay [1/s]':>13}   FMUs that participate"]
    for pole in found:
        growth = pole.growth_per_cycle
        shown = "-" if growth is None else f"{growth:.4g}"
        parts = ", ".join(f"{name} {100 * share:.0f} %" for name, share in pole.parts[:4])
        rows.append(f"  {pole.frequency:>10.4f}{pole.zeta:>12.6f}{shown:>10}{pole.s.real:>13.4f}   {parts}")
    return rows


def _margin_lines(found: Sequence[Margin]) -> list[str]:
    if not found:
        return []
    wide = max(len(f"{m.source} -> {m.target}") for m in found) + 2
    rows = ["", f"  {'connection':<{wide}}{'delay [ms]':>11}{'gain up':>10}{'down':>8}   what more it bears"]
    for m in found:
        delay = "-" if m.delay is None else f"{1e3 * m.delay:.3f}"
        gains = ["-" if g is None else f"{g:.4g}" for g in (m.gain_up, m.gain_down)]
        at = "" if m.frequency is None else f"   oscillates at {m.frequency:.3f} Hz"
        rows.append(f"  {m.source + ' -> ' + m.target:<{wide}}{delay:>11}{gains[0]:>10}{gains[1]:>8}{at}")
    return rows


def _tail(analysis: Analysis) -> list[str]:
    assumed = [f"assumed: {a.signal} = {a.value} ({a.reason})" for a in analysis.assumptions]
    notes = [f"note: {n}" for n in analysis.notes]
    return ["", *assumed, *notes] if assumed or notes else []
