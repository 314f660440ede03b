"""The answer: one sentence, and everything that it rests on as one object."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from fmu_sources.effects.catalogue import effect, listed
from fmu_sources.effects.framework.experiment import Experiment
from master.diagnosis.adequacy.channels import Adequacy
from master.diagnosis.case.carriers import ANSWER
from master.diagnosis.judge.diagnose import Diagnosis
from master.diagnosis.judge.part_result import PartResult
from master.diagnosis.numerics.gains import SMALLEST_GAIN
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.replay.start_values import HEAD
from master.diagnosis.search.classes import are_of_a_class, class_of
from master.diagnosis.search.families import Ranked
from master.diagnosis.search.simplify import AND
from master.diagnosis.search.unknown_numbers import of_effect

from .before_after import SealedPart
from .claims import NEAR_BEST, Status, Verdict, claims, shape, verdict

UNNAMED = "a law without a name explains more"
REWRITTEN = "others explain more, or make it needless"
N_CORRELATIONS = 5
MOST_PREDICTORS = 6


def sentence(diagnosis: Diagnosis, sealed: Mapping[str, SealedPart]) -> str:
    """The verdict for people."""
    parts = [p for p in diagnosis.parts if p.is_judged]
    found = [c for p in parts for c in claims(p, sealed[p.name])]
    unknown_numbers = {k: v for p in parts for k, v in p.unknown_numbers.items()}
    names = " and ".join(_named(c.placed, unknown_numbers) for c in found if c.status is Status.TRACED)
    classes = "; ".join(" or ".join(f) for p in parts for f in p.families)
    nearest = _nearest(parts, sealed)
    rest = _rest(parts)
    unconfirmed = " and ".join(str(c.placed) for c in found if c.status is Status.NOT_CONFIRMED)
    if unconfirmed:
        rest = f"{rest}, with {unconfirmed}, which the sealed part does not confirm"
    kind = verdict(diagnosis, sealed)
    certain = f"Traced: {names}. " if names else ""
    one_of = f"One of a class, which member is not sure: {classes}." if classes else ""
    texts = {
        Verdict.TRACED: f"Traced: {names}.",
        Verdict.PARTLY: f"{certain}{one_of} A remainder is left: {rest}.{nearest}",
        Verdict.ONE_OF_A_CLASS: f"{certain}{one_of}",
        Verdict.UNDECLARED: f"Undeclared: {_shape(parts, rest)}.{nearest}",
        Verdict.NOT_CONFIRMED: (
            f"Not confirmed on the sealed part: {unconfirmed}; nothing is written as corrected. "
            f"Left: {_rest(parts)}."
        ),
        Verdict.UNEXPLAINED: f"Unexplained, not predictable: {rest}.",
        Verdict.PARAMETERS: "Parameters only: the model holds with other numbers.",
        Verdict.NOTHING: "Nothing missing: what is left depends on none of the signals.",
        Verdict.SOFTWARE: "; ".join(str(p.software_fault) for p in parts if p.software_fault is not None),
    }
    worse = [p.name for p in parts if sealed[p.name].is_refit_worse]
    told = (
        f" The nominal values fit the sealed part of {', '.join(worse)} better than the refit."
        if worse
        else ""
    )
    channels = "".join(f" {str(f)[0].upper()}{str(f)[1:]}." for p in parts for f in p.channel_faults)
    failed = "".join(f" {name}: {own.failure}." for name, own in sealed.items() if own.failure)
    unknown = "".join(f" {p.name}: {p.unknown}." for p in diagnosis.parts if p.unknown)
    cut = "" if diagnosis.is_complete else " Stopped before all was tried: this is the best so far."
    return (
        " ".join(texts[kind].split())
        + channels
        + _rows(diagnosis)
        + _late(diagnosis)
        + told
        + unknown
        + failed
        + cut
    )


def _rows(diagnosis: Diagnosis) -> str:
    """Inputs that are taken from another row than the FMUs' descriptions lead to."""
    changed = {name: row for part in diagnosis.parts for name, row in part.changed_rows.items()}
    if not changed:
        return ""
    listed_rows = ", ".join(f"{name} at the {row} of each step" for name, row in changed.items())
    return f" Measured inputs one row off from what the FMU says: {listed_rows}."


def _late(diagnosis: Diagnosis) -> str:
    """What it costs that an effect before a foreign FMU resists a motion that this FMU gives."""
    carriers = diagnosis.system.carriers
    return "".join(
        f" {_lateness(diagnosis, part, e)}"
        for part in diagnosis.parts
        for e in part.chosen.effects
        if e.fmu in carriers and carriers[e.fmu].is_late and e.slot != ANSWER
    )


def _lateness(diagnosis: Diagnosis, part: PartResult, placed: PlacedEffect) -> str:
    """
    When an effect acts that sees the motion: its force is held over a step, or interpolated by the FMU.

    A run has no measured motion: its follower sees what the FMU gave before the step.
    """
    system = diagnosis.system
    fmu = system.carriers[placed.fmu].fmu
    bench = part.study.bench
    step = 1e3 * bench.period / bench.options.oversample
    row = bench.part.inputs[placed.fmu]["der_q"].row
    shift = "late" if row == "start" else "early"
    held = f"held over each step from its {row}, half a step ({0.5 * step:.3g} ms) {shift}"
    acts = "without delay" if "input_hold" in system.descriptions[fmu].by_name else held
    return (
        f"{placed} acts at the measured speed, {acts}; in a run of the corrected system at that which {fmu} "
        f"gave before, up to a step ({step:.3g} ms) late."
    )


def _named(placed: PlacedEffect, unknown: Mapping[str, str]) -> str:
    """An effect, with what has no number; one added to the output of a sensor is a zero error of it."""
    is_zero = placed.law.constant is not None and placed.slot == "output"
    notes = ["a zero error of the sensor"] if is_zero else []
    without = of_effect(placed, unknown)
    if without:
        notes.append(f"without a number: {', '.join(without)}")
    return f"{placed} ({'; '.join(notes)})" if notes else str(placed)


def _rest(parts: Sequence[PartResult]) -> str:
    """What is left of the channels that are not explained."""
    left = [c for p in parts for c in p.final.channels if not c.is_adequate]
    left.sort(key=lambda c: -c.ratio)
    return "; and ".join(shape(c) for c in left[:2]) or "nothing that the channels could tell"


def _shape(parts: Sequence[PartResult], rest: str) -> str:
    learned = [p.learned.shape for p in parts if p.learned is not None and p.learned.model == p.chosen]
    told = "; ".join(learned)
    before = "; ".join(shape(p.stages[0].worst) for p in parts if not p.stages[0].is_adequate)
    return "; ".join(t for t in (told, before or rest) if t)


def _nearest(parts: Sequence[PartResult], sealed: Mapping[str, SealedPart]) -> str:
    """The best names that do not suffice, with what they explain and leave."""
    texts = []
    for p in parts:
        own = sealed[p.name]
        names = [c for c in claims(p, own) if c.status is Status.NEAREST]
        if names:
            ratio = p.final.worst.ratio
            texts.append(
                f" Nearest name: {' and '.join(str(c.placed) for c in names)}, explains "
                f"{100.0 * own.explained_share:.0f} %, leaves {ratio:.3g} times the noise floor "
                f"({names[0].why})."
            )
    return "".join(texts)


def as_dict(diagnosis: Diagnosis, sealed: Mapping[str, SealedPart], files: list[str]) -> dict[str, Any]:
    """Everything, ready for JSON."""
    main = diagnosis.main
    own = sealed[main.name]
    return {
        "name": diagnosis.loaded.case.name,
        "verdict": verdict(diagnosis, sealed).value,
        "sentence": sentence(diagnosis, sealed),
        "complete": diagnosis.is_complete,
        "effects": [e for p in diagnosis.parts for e in _effects(p, sealed[p.name])],
        "subsystem": subsystem(diagnosis),
        "faults": [p.software_fault.as_dict() for p in diagnosis.parts if p.software_fault is not None],
        "before": _errors(sealed, "before"),
        "after": _errors(sealed, "after"),
        "nominal": _errors(sealed, "nominal"),
        "explained_share": own.explained_share,
        "ceiling": _ceiling(main, own),
        "channels": {c: v for p in diagnosis.parts for c, v in _channels(p).items()},
        "runners_up": _runners_up(main, own),
        "classes": _classes(main, own),
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
        "recordings": {
            name: {"rows": len(r), "period": r.period, "notes": [*r.notes, *_estimated(name, sealed)]}
            for name, r in diagnosis.recordings.items()
        },
        "residual": {p.name: _residual(p) for p in diagnosis.parts},
        "files": files,
    }


def _estimated(recording: str, sealed: Mapping[str, SealedPart]) -> Iterator[str]:
    """What was estimated on the rows of a recording with sealed rows, and whether they are scored."""
    for part in sealed.values():
        own = {s: e for s, e in part.estimates.items() if s.recording == recording}
        names = ", ".join(dict.fromkeys(name for e in own.values() for name in e.names))
        if any(e.rows == len(s) for s, e in own.items()):
            each = f" of each of {len(own)} windows" if len(own) > 1 else ""
            yield f"{names}: estimated on the rows{each} that are compared"
        elif own:
            rows = sum(e.rows for e in own.values())
            share = f"{100.0 * HEAD:.0f} %"
            yield f"{names}: estimated on its first {share} ({rows} rows), which no error is counted on"


def subsystem(diagnosis: Diagnosis) -> str | None:
    """FMU that the effect is in; None without one."""
    main = diagnosis.main
    if main.fmus:
        return main.fmus[0]
    faulty = [p for p in diagnosis.parts if p.software_fault is not None]
    left = [p for p in diagnosis.parts if p.is_judged and not p.final.is_adequate]
    return next((_likely_place(p) for p in (*faulty, *left)), None)


def _likely_place(part: PartResult) -> str:
    """
    FMU of a part that what is left points to.

    It is that of the slot whose law predicts about as much as anything does, else that of the slot whose
    signal the best regressor follows, else that of the channel itself.
    """
    fmus = part.study.bench.part.fmus
    if len(fmus) == 1 or not part.stages:
        return part.name
    worst = part.final.worst
    best = worst.best
    if best is not None and worst.is_predictable:
        near = (p.law for p in worst.predictors if p.share.value > NEAR_BEST * best.share.value)
        law = next((law for law in near if law is not None), None)
        if law is not None:
            return law.place.partition(".")[0]
        for fmu in fmus:
            if f" of {fmu}." in f" of {best.of}":
                return fmu
    return worst.signal.partition(".")[0]


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


def _effects(part: PartResult, sealed: SealedPart) -> list[dict[str, Any]]:
    """Effects with parameters, status, sealed gain, and what is left over the noise floor."""
    effects = []
    for claim in claims(part, sealed):
        e = claim.placed
        unknown = of_effect(e, part.unknown_numbers)
        gain = sealed.gains.get(str(e))
        effects.append(
            {
                "fmu": e.fmu,
                "slot": e.slot,
                "effect": e.effect,
                "parameters": {
                    e.short_name(k): None if e.short_name(k) in unknown else float(v)
                    for k, v in part.values.items()
                    if e.owns(k)
                },
                "no_number": dict(unknown),
                "status": claim.status.value,
                "why": claim.why,
                "sealed_gain": None if gain is None else gain.value,
                "sealed_gain_interval": None if gain is None else list(gain.interval),
                "left_over_floor": max(c.ratio for c in part.final.channels),
            }
        )
    return effects


def _ceiling(part: PartResult, sealed: SealedPart) -> dict[str, Any] | None:
    """
    What could be predicted of the residual of the refit, and what still can be after the effects.

    The effects predict too: where they explain more than the regressors, the ceiling is theirs.
    """
    if not part.stages:
        return None
    first = part.stages[0].channels
    share = float(np.mean([c.share.value for c in first]))
    low, high = (float(np.mean([getattr(c.share.interval, end) for c in first])) for end in ("low", "high"))
    explained = sealed.explained_share if part.has_effect else 0.0
    last = part.final.channels
    return {
        "share": max(share, explained, 0.0),
        "by_regressors": share,
        "interval": [low, high],
        "error": 0.25 * (high - low),
        "share_after": float(np.mean([c.share.value for c in last])),
        "error_after": float(np.mean([c.share.error for c in last])),
    }


def _channels(part: PartResult) -> dict[str, Any]:
    """Adequacy of each compared channel along the stages."""
    found = {}
    for i, name in enumerate(part.outputs):
        if not part.stages:
            found[name] = {"exact": part.is_exact, "unknown": part.unknown, "stages": []}
            continue
        last = part.final.channels[i]
        found[name] = {
            "exact": False,
            "noise_floor": last.floor.value,
            "evidence": last.floor.evidence.value,
            "noise_of_inputs": last.passed,
            "adequate": last.is_adequate,
            "colour": last.colour.words,
            "events": list(last.events),
            "strikes": list(last.strikes),
            "faults": [
                {"kind": f.kind, "value": f.value, "deviation": f.deviation, "text": str(f)}
                for f in part.channel_faults
                if f.signal == name
            ],
            "stages": [_stage(stage.name, stage.channels[i]) for stage in part.stages],
        }
    return found


def _stage(name: str, c: Adequacy) -> dict[str, Any]:
    return {
        "model": name,
        "rms": c.rms,
        "over_floor": c.ratio,
        "predictable_share": c.share.value,
        "interval": list(c.share.interval),
        "predictors": [
            {"what": str(p), "share": p.share.value, "interval": list(p.share.interval)}
            for p in c.predictors[:MOST_PREDICTORS]
        ],
    }


def _classes(part: PartResult, sealed: SealedPart) -> list[dict[str, Any]]:
    """Class of each round's winner, and what every member of it leaves on the sealed rows."""
    found = []
    for i, step in enumerate(() if part.search is None else part.search.rounds, start=1):
        if not step.family:
            continue
        first = step.family[0].model.effects[-1]
        members = [r for r in step.ranked if are_of_a_class(r.model.effects[-1], first) or r in step.family]
        not_told = [r.name for r in step.family]
        found.append(
            {
                "round": i,
                "class": class_of(first.law),
                "members": [
                    {
                        "effect": r.name,
                        "gain": r.gain.mean,
                        "sealed_rmse": sealed.rivals.get(r.name, {}),
                        "cannot_be_told": r.name in not_told and len(not_told) > 1,
                    }
                    for r in members
                ],
            }
        )
    return found


def _runners_up(part: PartResult, sealed: SealedPart) -> list[dict[str, Any]]:
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
            left = sealed.rivals.get(r.name, {})
            rows.append(
                {"round": i, "effect": r.name, "gain": r.gain.mean, "why": why, "sealed_rmse": dict(left)}
            )
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
            "refitted": None if name in part.unknown_when_refitted else base.values.get(name),
            "deviation_refitted": _finite(base.deviations.get(name)),
            "with_effect": None if name in part.unknown_numbers else value,
            "deviation": _finite(fit.deviations[name]),
            "at_bound": name in fit.at_bound,
            "no_number": part.unknown_numbers.get(name, ""),
        }
        for name, value in fit.values.items()
        if not any(e.owns(name) for e in learned)
    }


def _finite(deviation: float | None) -> float | None:
    return deviation if deviation is not None and np.isfinite(deviation) else None


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
    }
