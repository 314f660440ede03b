"""The answer: one sentence, and everything that it rests on as one object."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from fmu_sources.effects.catalogue import effect, listed
from fmu_sources.effects.framework.experiment import Experiment
from master.diagnosis.judge.diagnose import Diagnosis
from master.diagnosis.judge.part_result import PartResult
from master.diagnosis.numerics.gains import SMALLEST_GAIN
from master.diagnosis.search.families import Ranked
from master.diagnosis.search.simplify import AND

from .before_after import SealedPart

TRACED = "traced"
PARTLY = "partly, with an undeclared remainder"
UNDECLARED = "undeclared"
UNTOLD = "cannot be told"
PARAMETERS = "parameters only"
NOTHING = "nothing missing"

UNNAMED = "a law without a name explains more"
REWRITTEN = "others explain more, or make it needless"
CLEARLY_DRIFTING = 1e-6  # chance that one number fits, below which a parameter that drifts is a finding
N_CORRELATIONS = 5


def verdict(diagnosis: Diagnosis) -> str:
    """One of the six verdicts, from the part with the strongest effect."""
    main = diagnosis.main
    if any(p.has_effect for p in diagnosis.parts):
        if not main.is_named:
            return UNDECLARED
        if main.has_remainder:
            return PARTLY
        return UNTOLD if main.families else TRACED
    if any(p.has_remainder or _is_unexplained(p) for p in diagnosis.parts):
        return UNDECLARED
    return PARAMETERS if any(p.parameter_gain for p in diagnosis.parts) else NOTHING


def sentence(diagnosis: Diagnosis) -> str:
    """The verdict for people."""
    main = diagnosis.main
    names = " and ".join(str(e) for e in main.chosen.effects if e.effect in listed())
    texts = {
        TRACED: f"Traced: {names}.",
        PARTLY: f"Partly traced: {names}; an undeclared remainder is left.",
        UNDECLARED: f"Undeclared: {_shape(main)}.",
        UNTOLD: f"{_certain(main)}Cannot be told: {'; '.join(' or '.join(f) for f in main.families)}.",
        PARAMETERS: "Parameters only: the model holds with other numbers.",
        NOTHING: "Nothing missing: what is left depends on none of the signals.",
    }
    return texts[verdict(diagnosis)] + _rows(diagnosis)


def _rows(diagnosis: Diagnosis) -> str:
    """Inputs that are taken from another row than the FMUs' descriptions lead to."""
    changed = {name: row for part in diagnosis.parts for name, row in part.changed_rows.items()}
    if not changed:
        return ""
    listed_rows = ", ".join(f"{name} at the {row} of each step" for name, row in changed.items())
    return f" Measured inputs one row off from what the FMU says: {listed_rows}."


def _certain(main: PartResult) -> str:
    """Effects that are beyond doubt, where others are not."""
    doubtful = {name for family in main.families for name in family}
    names = [str(a) for a in main.chosen.effects if str(a) not in doubtful]
    return f"Traced: {' and '.join(names)}. " if names else ""


def as_dict(diagnosis: Diagnosis, sealed: Mapping[str, SealedPart], files: list[str]) -> dict[str, Any]:
    """Everything, ready for JSON."""
    main = diagnosis.main
    own = sealed[main.name]
    return {
        "name": diagnosis.loaded.case.name,
        "verdict": verdict(diagnosis),
        "sentence": sentence(diagnosis),
        "effects": [e for p in diagnosis.parts for e in _effects(p)],
        "subsystem": subsystem(diagnosis),
        "before": _errors(sealed, "before"),
        "after": _errors(sealed, "after"),
        "nominal": _errors(sealed, "nominal"),
        "explained_share": own.explained_share,
        "ceiling": _ceiling(main),
        "runners_up": _runners_up(main),
        "undistinguished": [
            {"family": list(f), "experiment": experiment(f)} for p in diagnosis.parts for f in p.families
        ],
        "parameters": {k: v for p in diagnosis.parts for k, v in _parameters(p).items()},
        "input_rows": {
            f"{fmu}.{variable}": given.row
            for part in diagnosis.parts
            for fmu, own in part.study.bench.part.inputs.items()
            for variable, given in own.items()
        },
        "changed_rows": {name: row for p in diagnosis.parts for name, row in p.changed_rows.items()},
        "residual": {p.name: _residual(p) for p in diagnosis.parts},
        "files": files,
    }


def subsystem(diagnosis: Diagnosis) -> str | None:
    """FMU that the effect is in; None without one."""
    main = diagnosis.main
    if main.fmus:
        return main.fmus[0]
    drifting = [p for p in diagnosis.parts if p.has_remainder or _is_unexplained(p)]
    return drifting[0].name if drifting else None


def experiment(family: tuple[str, ...]) -> str:
    """What to record to tell the members of a family apart."""
    names = {name.rpartition(": ")[2] for member in family for name in member.split(AND)}
    laws = [effect(name) for name in names]
    fitting = (e for e in Experiment if all(e in law.shown_by for law in laws))
    return next(fitting, Experiment.OTHER_AMPLITUDE).value


def _errors(sealed: Mapping[str, SealedPart], which: str) -> dict[str, Any]:
    """Errors on the sealed rows of the prediction `before`, `after` or `nominal`, by signal."""
    return {
        signal: asdict(errors)
        for part in sealed.values()
        for signal, errors in part.errors_of(getattr(part, which)).items()
    }


def _is_unexplained(part: PartResult) -> bool:
    """A residual with structure, or parameters that drift, and no effect to show for it."""
    if part.has_effect or part.is_exact:
        return False
    has_structure = part.ceiling_after is not None and part.ceiling_after.is_structure
    return has_structure or any(d.p_equal < CLEARLY_DRIFTING for d in part.drifts)


def _shape(part: PartResult) -> str:
    if part.learned is not None:
        return part.learned.shape
    moving = [d for d in part.drifts if not d.is_constant]
    if moving:
        worst = min(moving, key=lambda d: d.p_equal)
        return f"{worst.parameter} is not one number, it changes along {worst.along}"
    return f"the residual of {part.name} depends on its signals"


def _effects(part: PartResult) -> list[dict[str, Any]]:
    effects = []
    for e in part.chosen.effects:
        own = {e.short_name(k): float(v) for k, v in part.values.items() if e.owns(k)}
        effects.append({"fmu": e.fmu, "slot": e.slot, "effect": e.effect, "parameters": own})
    return effects


def _ceiling(part: PartResult) -> dict[str, float] | None:
    if part.ceiling is None:
        return None
    shares = {"share": part.ceiling.share, "error": part.ceiling.error}
    if part.ceiling_after is not None:
        shares |= {"share_after": part.ceiling_after.share, "error_after": part.ceiling_after.error}
    return {k: float(v) for k, v in shares.items() if np.isfinite(v)}


def _runners_up(part: PartResult) -> list[dict[str, Any]]:
    """Effects that were fitted and lost; where the answer has no name, the best of each round too."""
    rows = []
    for i, step in enumerate(() if part.search is None else part.search.rounds, start=1):
        winner = step.family[0] if step.family else None
        members = [r.name for r in step.family]
        for r in step.ranked:
            if r is winner and part.is_named and r.model.effects[-1] in part.chosen.effects:
                continue
            why = _why(r, winner, members)
            if r is winner:
                why = REWRITTEN if part.is_named else UNNAMED
            rows.append({"round": i, "effect": r.name, "gain": r.gain.mean, "why": why})
    return rows


def _why(r: Ranked, winner: Ranked | None, members: Sequence[str]) -> str:
    if r.name in members:
        return "cannot be told from the winner"
    if winner is None or not r.gain.is_accepted:
        return (
            f"gain {r.gain.mean:.3g} +- {r.gain.error:.2g} on held-out blocks is not above "
            f"{100.0 * SMALLEST_GAIN:g} % and chance"
        )
    if r.gain.mean >= winner.gain.mean - SMALLEST_GAIN:
        return "predicts the same as the winner with more parameters"
    return f"explains less, gain {r.gain.mean:.3g} against {winner.gain.mean:.3g}"


def _parameters(part: PartResult) -> dict[str, Any]:
    """What was fitted, of base and effects; the many coefficients of a learned law are drawn instead."""
    nominal = {p.name: p.start for p in part.study.base}
    base = part.base
    fit = part.fit
    learned = [e for e in part.chosen.effects if e.effect not in listed()]
    return {
        name: {
            "nominal": nominal.get(name),
            "refitted": base.values.get(name),
            "deviation_refitted": base.deviations.get(name),
            "with_effect": value,
            "deviation": fit.deviations[name],
            "at_bound": name in fit.at_bound,
        }
        for name, value in fit.values.items()
        if not any(e.owns(name) for e in learned)
    }


def _residual(part: PartResult) -> dict[str, Any]:
    return {
        "exact": part.is_exact,
        "rms": dict(zip(part.outputs, part.study.output_scale.tolist(), strict=True)),
        "whiteness_p": part.whiteness,
        "correlations": [
            {"basis": c.basis, "lag": c.lag, "value": c.value, "p": c.p, "found": c.is_found}
            for c in part.correlations[:N_CORRELATIONS]
        ],
        "drift": [
            {"parameter": d.parameter, "p_equal": d.p_equal, "along": d.along, "slope": d.slope}
            for d in part.drifts
        ],
        "ceiling": _ceiling(part),
    }
