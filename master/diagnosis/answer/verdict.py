"""The answer: one sentence, and everything behind it as one object."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from fmu_sources.effects.catalogue import effect, listed
from fmu_sources.effects.framework.experiment import Experiment
from master.diagnosis.judge.diagnose import Diagnosis
from master.diagnosis.judge.part_result import PartResult
from master.diagnosis.search.families import Ranked
from master.diagnosis.search.simplify import AND

from .before_after import SealedPart

TRACED, PARTLY, UNDECLARED = "traced", "partly, with an undeclared remainder", "undeclared"
UNNAMED = "a law without a name explains more"
REWRITTEN = "others explain more, or make it needless"
PARAMETERS, NOTHING, UNTOLD = "parameters only", "nothing missing", "cannot be told"


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
    main, kind = diagnosis.main, verdict(diagnosis)
    names = " and ".join(str(a) for a in main.chosen.added if a.effect in listed())
    texts = {
        TRACED: f"Traced: {names}.",
        PARTLY: f"Partly traced: {names}; an undeclared remainder is left.",
        UNDECLARED: f"Undeclared: {_shape(main)}.",
        UNTOLD: f"{_certain(main)}Cannot be told: {'; '.join(' or '.join(f) for f in main.families)}.",
        PARAMETERS: "Parameters only: the model holds with other numbers.",
        NOTHING: "Nothing missing: what is left hangs on none of the signals.",
    }
    return texts[kind]


def _certain(main: PartResult) -> str:
    """Effects that are beyond doubt beside those that are not."""
    doubtful = {name for family in main.families for name in family}
    names = [str(a) for a in main.chosen.added if str(a) not in doubtful]
    return f"Traced: {' and '.join(names)}. " if names else ""


def as_dict(diagnosis: Diagnosis, sealed: Mapping[str, SealedPart], files: list[str]) -> dict[str, Any]:
    """Everything, ready for JSON."""
    main = diagnosis.main
    own = sealed[main.study.bench.part.name]
    return {
        "name": diagnosis.loaded.case.name,
        "verdict": verdict(diagnosis),
        "sentence": sentence(diagnosis),
        "effects": [e for p in diagnosis.parts for e in _effects(p)],
        "subsystem": subsystem(diagnosis),
        "before": {k: v for s in sealed.values() for k, v in s.table("before").items()},
        "after": {k: v for s in sealed.values() for k, v in s.table("after").items()},
        "nominal": {k: v for s in sealed.values() for k, v in s.table("nominal").items()},
        "explained_share": own.explained_share,
        "ceiling": _ceiling(main),
        "runners_up": _runners_up(main),
        "undistinguished": [
            {"family": list(f), "experiment": experiment(f)} for p in diagnosis.parts for f in p.families
        ],
        "parameters": {k: v for p in diagnosis.parts for k, v in _parameters(p).items()},
        "residual": {p.study.bench.part.name: _residual(p) for p in diagnosis.parts},
        "files": files,
    }


def subsystem(diagnosis: Diagnosis) -> str | None:
    """FMU that the effect is in; None without one."""
    main = diagnosis.main
    if main.fmus:
        return main.fmus[0]
    drifting = [p for p in diagnosis.parts if p.has_remainder or _is_unexplained(p)]
    return drifting[0].study.bench.part.name if drifting else None


def experiment(family: tuple[str, ...]) -> str:
    """What to record to tell the members of a family apart."""
    names = {name.rpartition(": ")[2] for member in family for name in member.split(AND)}
    laws = [effect(name) for name in names]
    fitting = (e for e in Experiment if all(e in law.shown_by for law in laws))
    return next(fitting, Experiment.OTHER_AMPLITUDE).value


def _is_unexplained(part: PartResult) -> bool:
    """A residual with structure, or parameters that drift, and no effect to show for it."""
    if part.has_effect or part.is_exact:
        return False
    has_structure = part.ceiling_after is not None and part.ceiling_after.is_structure
    return has_structure or any(d.p_equal < 1e-6 for d in part.drifts)


def _shape(part: PartResult) -> str:
    if part.learned is not None:
        return part.learned.shape
    moving = [d for d in part.drifts if not d.is_constant]
    if moving:
        worst = min(moving, key=lambda d: d.p_equal)
        return f"{worst.parameter} is not one number, it changes along {worst.along}"
    return f"the residual of {part.study.bench.part.name} hangs on its signals"


def _effects(part: PartResult) -> list[dict[str, Any]]:
    values = dict(part.chosen.fixed) | dict(part.fit.values)
    found = []
    for a in part.chosen.added:
        begin = f"{a.fmu}.{a.prefix}_"
        own = {k.removeprefix(begin): float(v) for k, v in values.items() if k.startswith(begin)}
        found.append({"fmu": a.fmu, "slot": a.slot, "effect": a.effect, "parameters": own})
    return found


def _ceiling(part: PartResult) -> dict[str, float] | None:
    if part.ceiling is None:
        return None
    found = {"share": part.ceiling.share, "error": part.ceiling.error}
    if part.ceiling_after is not None:
        found |= {"share_after": part.ceiling_after.share, "error_after": part.ceiling_after.error}
    return {k: float(v) for k, v in found.items() if np.isfinite(v)}


def _runners_up(part: PartResult) -> list[dict[str, Any]]:
    """Effects that were fitted and lost; where the answer has no name, the best of each round too."""
    rows = []
    for i, step in enumerate(() if part.found is None else part.found.rounds, start=1):
        winner = step.family[0] if step.family else None
        members = [r.name for r in step.family]
        for r in step.ranked:
            if r is winner and part.is_named and r.extended.added[-1] in part.chosen.added:
                continue
            why = _why(r, winner, members)
            if r is winner:
                why = REWRITTEN if part.is_named else UNNAMED
            rows.append({"round": i, "effect": r.name, "gain": r.gain.mean, "why": why})
    return rows


def _why(r: Ranked, winner: Ranked | None, members: list[str]) -> str:
    if r.name in members:
        return "cannot be told from the winner"
    if winner is None or not r.gain.is_accepted:
        return f"gain {r.gain.mean:.3g} +- {r.gain.error:.2g} on held-out blocks is not above 1 % and chance"
    if r.gain.mean >= winner.gain.mean - 0.01:
        return "predicts the same as the winner with more parameters"
    return f"explains less, gain {r.gain.mean:.3g} against {winner.gain.mean:.3g}"


def _parameters(part: PartResult) -> dict[str, Any]:
    """What was fitted, of base and effects; the many coefficients of a learned law are drawn instead."""
    nominal, base, fit = {p.name: p.start for p in part.study.base}, part.base, part.fit
    learned = tuple(f"{a.fmu}.{a.prefix}_" for a in part.chosen.added if a.effect not in listed())
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
        if not name.startswith(learned)
    }


def _residual(part: PartResult) -> dict[str, Any]:
    return {
        "exact": part.is_exact,
        "rms": dict(zip(part.study.bench.outputs, part.study.size.tolist(), strict=True)),
        "whiteness_p": part.whiteness,
        "correlations": [
            {"basis": c.basis, "lag": c.lag, "value": c.value, "p": c.p, "found": c.is_found}
            for c in part.correlations[:5]
        ],
        "drift": [
            {"parameter": d.parameter, "p_equal": d.p_equal, "along": d.along, "slope": d.slope}
            for d in part.drifts
        ],
        "ceiling": _ceiling(part),
    }
