"""From a case to what each part lacks: localise, refit, judge, rank, name or learn, judge again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from types import TracebackType

import numpy as np

from master import catalogue
from master.diagnosis.adequacy.channels import Judge
from master.diagnosis.case.case import Case, LoadedCase
from master.diagnosis.case.cut import CutPart, CutSystem
from master.diagnosis.case.split import Split, Stretch, blocks
from master.diagnosis.data.measured_signals import opened
from master.diagnosis.data.recordings import Recording
from master.diagnosis.data.split_rows import split_of
from master.diagnosis.numerics.arrays import Mask
from master.diagnosis.numerics.gains import gain
from master.diagnosis.numerics.least_squares import Fit
from master.diagnosis.replay.candidate_models import ModelPool
from master.diagnosis.replay.fitting_effects import candidates
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.diagnosis.replay.replay_bench import ReplayBench
from master.diagnosis.search.classes import CONVERTER, class_of
from master.diagnosis.search.deadline import Deadline, TimeIsUpError
from master.diagnosis.search.extended_model import ExtendedModel
from master.diagnosis.search.leading import led_by_the_unobjected
from master.diagnosis.search.limits import named_by_limits
from master.diagnosis.search.objections import objections
from master.diagnosis.search.rounds import search
from master.diagnosis.search.several_slots import with_laws_in_several_slots
from master.diagnosis.search.simplify import with_rewritings
from master.diagnosis.search.study import Progress, base_parameters, begin
from master.diagnosis.search.unknown_numbers import unknown_numbers
from master.errors import ConfigError, FmuError
from master.text.signal_name import SignalName

from .channel_faults import ChannelFault, channel_faults, is_best
from .cost import cost_of
from .evidence import detect
from .input_rows import changed_rows, is_better, other_rows
from .named_or_learned import named_or_learned
from .names_beside import with_names_beside
from .part_result import PartResult
from .plausible import implausible
from .refit import refitted
from .sharp_reversals import with_sharp_reversals
from .software_fault import is_software, software_fault, ticks_between_rows, unknown_rows
from .stages import REFIT, Stage

N_BLOCKS = 12  # that select
CONTRADICTING = ("sign", "size")  # faults of a channel that are told whatever explains them
MOVED = 3.0  # standard deviations: a parameter that differs from the system's value
LEAST_DEVIATION = 1e-12  # of the scale, where a fit is exact


@dataclass(frozen=True)
class Diagnosis:
    """
    All parts of a case, before the sealed rows are read.

    Their FMUs stay loaded until it is closed; it is a context manager.
    """

    loaded: LoadedCase
    system: CutSystem
    recordings: Mapping[str, Recording]
    parts: tuple[PartResult, ...]
    split: Split
    open_models: ExitStack = field(repr=False)
    is_complete: bool = True

    def __enter__(self) -> Diagnosis:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def main(self) -> PartResult:
        """
        The part with the effect that explains most of its residual.

        Where there is none, the part of which most is left: of faulty software, then of what can be
        predicted, then over the noise floor.
        """

        def share(part: PartResult) -> float:
            if not part.has_effect:
                return -1.0
            rows = part.study.fit_rows
            base, own = (
                np.nanmean(((f.predicted - part.measured) / part.study.output_scale)[rows] ** 2)
                for f in (part.base, part.fit)
            )
            return float(np.log(base / own))

        if any(part.has_effect for part in self.parts):
            return max(self.parts, key=share)
        return max(self.parts, key=_what_is_left)

    def close(self) -> None:
        """Unload all FMUs."""
        self.open_models.close()


def _what_is_left(part: PartResult) -> tuple[bool, float, float]:
    """How much speaks for a part as the one that lacks something."""
    if not part.stages:
        return (part.software_fault is not None, -1.0, 0.0)
    worst = part.final.worst
    share = worst.share.value if worst.is_predictable else 0.0
    return (part.software_fault is not None, share, worst.ratio)


def diagnose(
    loaded: LoadedCase,
    progress: Progress,
    deadline: Deadline | None = None,
    announce: Progress = catalogue.silent,
) -> Diagnosis:
    """
    Study all parts of a case on the rows to fit on and to select by.

    Args:
        loaded: The case.
        progress: Told what is being done.
        deadline: When to stop searching and report the best so far.
        announce: Told once, before anything is replayed, what the diagnosis will cost.

    Raises:
        ConfigError: If the case, its system or its recordings are wrong.
    """
    deadline = deadline or Deadline()
    watched = deadline.watched(progress)
    system, recordings = opened(loaded, watched)
    loaded = system.loaded

    def say(text: str) -> None:
        watched(system.spoken(text))

    split = split_of(loaded, recordings)
    if announce is not catalogue.silent:
        announce(f"{cost_of(loaded, system, recordings, split)}")
    with ExitStack() as stack:
        begun = []
        for part in system.parts:
            begun.append(_with_best_rows(stack, system, part, recordings, split, loaded.case, say))
        problems = implausible(loaded, begun)
        if problems:
            raise ConfigError([system.spoken(problem) for problem in problems])
        results = tuple(_searched(part, system, loaded.case, deadline) for part in begun)
        return Diagnosis(
            loaded, system, recordings, results, split, stack.pop_all(), is_complete=not deadline.has_stopped
        )


def _with_best_rows(
    stack: ExitStack,
    system: CutSystem,
    part: CutPart,
    recordings: Mapping[str, Recording],
    split: Split,
    case: Case,
    progress: Progress,
) -> PartResult:
    """Begin with the rows of the inputs that explain the part best; its models are closed with the stack."""

    def begun(candidate: CutPart) -> PartResult:
        pool = stack.enter_context(ModelPool(system, candidate))
        return _begun(system, pool, recordings, split, case, progress)

    best = begun(part)
    others = () if best.is_exact else tuple(other_rows(system, part, case))
    for other in others:
        try:
            found = begun(other)
        except FmuError:  # an FMU that does not bear these rows
            continue
        if is_better(best, found, len(others)):
            best = replace(found, changed_rows=changed_rows(part, other))
        if best.is_exact:
            break
    return best


def _begun(
    system: CutSystem,
    pool: ModelPool,
    recordings: Mapping[str, Recording],
    split: Split,
    case: Case,
    progress: Progress,
) -> PartResult:
    """Replay and refit one part; recordings that are sealed as a whole are not looked at."""
    part = pool.part
    progress(f"{part.name}: replay and refit")
    unsealed = {name: r for name, r in recordings.items() if (r.entry or name) not in case.split.sealed}
    bench = ReplayBench(part, unsealed, case, fitted={s.recording for s in split.fit})
    rows = bench.in_use & _rows(bench, split.fit)
    held_out = [_slice(bench, s) for s in blocks(split.select, N_BLOCKS)]
    held_out = [s for s in held_out if bench.in_use[s].all()]
    seen = dict.fromkeys(unsealed[s.recording].entry or s.recording for s in split.fit)
    base = base_parameters(case, system, part.fmus, list(seen))
    study, fitted = begin(system, bench, pool, base, rows, held_out, progress)
    nominal = study.simulate((), {}, everything=True)
    return PartResult(study, nominal, fitted, ExtendedModel(), fitted, is_exact=study.is_exact)


def _searched(begun: PartResult, system: CutSystem, case: Case, deadline: Deadline) -> PartResult:
    """What one part lacks, if anything is left of it."""
    if begun.is_exact:
        return begun
    study = begun.study
    faster = ticks_between_rows(study)
    if faster:
        names = " and ".join(faster)
        why = f"{names} ticks between the rows of the recording, and what drove it there is not known"
        return replace(begun, unknown=why)
    if is_software(study):
        fault = software_fault(study, begun.base.values, begun.base.predicted)
        if fault is not None and fault.is_exact:
            judge = Judge(study, begun.base.values, begun.base.predicted)
            refit = Stage(REFIT, judge.judge(begun.base.predicted, thorough=False))
            return replace(begun, stages=(refit,), software_fault=fault)
        taken_off = {name: s.minus for name, s in case.signals.items() if s.minus is not None}
        why = unknown_rows(study, begun.base.values, begun.base.predicted, taken_off)
        if fault is not None and why:
            return replace(begun, unknown=why)
        begun = replace(begun, software_fault=fault)
    effects = candidates(system, study.bench.part, case.slots)
    study.say("what is left, and what still predicts it")
    judge = Judge(study, begun.base.values, begun.base.predicted)
    refit = Stage(REFIT, judge.judge(begun.base.predicted))
    result = replace(detect(begun), stages=(refit,))
    if refit.is_noise:  # differences take the steps of a converter for noise: it alone may be missing
        effects = [e for e in effects if class_of(e.law) == CONVERTER]
    if effects:
        deadline.arm()
        result = _explained(result, effects, judge)
        deadline.disarm()
    result = refitted(_parameters(with_sharp_reversals(result)))
    if result.has_effect:
        study.say("what is left after the effects")
        final = Stage(result.chosen.name, judge.judge(result.fit.predicted))
        result = replace(result, stages=(*result.stages, final))
        if final.is_adequate:  # the fault that came nearest did not explain the part, these effects do
            result = replace(result, software_fault=None)
    return replace(
        result,
        channel_faults=tuple(_channel_faults(result)),
        objections=objections(study, result.chosen, result.fit),
        unknown_numbers=unknown_numbers(study, result.chosen, result.fit),
        unknown_when_refitted=unknown_numbers(study, ExtendedModel(), result.base),
    )


def _explained(result: PartResult, effects: Sequence[PlacedEffect], judge: Judge) -> PartResult:
    """Names for what is left, or a law without one; the best so far where the time is up."""
    study = result.study
    places = sorted({e.place for e in effects})

    def is_adequate(fitted: Fit) -> bool:
        if fitted is result.base:
            return result.final.is_quiet
        return all(c.is_silent for c in judge.judge(fitted.predicted, thorough=False))

    def is_enough(fitted: Fit) -> bool:  # more than the floor is more, whether anything predicts it or not
        return all(c.is_adequate for c in judge.judge(fitted.predicted, thorough=False))

    def is_noise(fitted: Fit) -> bool:
        return all(c.is_silent and c.is_within_floor for c in judge.judge(fitted.predicted, thorough=False))

    named = search(study, result.base, effects, is_adequate=is_adequate, is_noise=is_noise)
    result = replace(result, search=named, chosen=named.model, fit=named.fit)
    try:
        named = with_laws_in_several_slots(study, named, effects, is_enough, is_noise)
        result = replace(result, search=named, chosen=named.model, fit=named.fit)
        named = named_by_limits(study, with_rewritings(study, named, effects), effects)
        named = led_by_the_unobjected(study, named)
        result = named_or_learned(result, named, places, judge)
        return with_names_beside(result, effects, judge)
    except TimeIsUpError:
        return result


def _channel_faults(result: PartResult) -> Iterator[ChannelFault]:
    """Faults of the channels: of the nominal model what contradicts it, of the last one what it leaves."""
    bench = result.study.bench
    for i, signal in enumerate(result.outputs):
        fmu, variable = SignalName(signal).parts
        unit = result.study.system.descriptions[fmu].by_name[variable].unit_name
        known = set()
        for predicted in (result.fit.predicted, result.base.predicted, result.nominal):
            rows = bench.in_use
            found = channel_faults(
                signal, result.measured[rows, i], predicted[rows, i], bench.row_period, unit
            )
            for fault in found:
                is_last = predicted is result.fit.predicted and is_best(fault, result.final.channels[i])
                if fault.kind not in known and (is_last or fault.kind in CONTRADICTING):
                    known.add(fault.kind)
                    yield fault


def _parameters(result: PartResult) -> PartResult:
    """Which parameters moved from their values, and whether that pays on held-out rows."""
    study = result.study
    fit = result.fit
    moved = {
        p.name: fit.values[p.name] - p.start
        for p in study.base
        if abs(fit.values[p.name] - p.start) > MOVED * max(fit.deviations[p.name], LEAST_DEVIATION * p.scale)
    }
    pays = gain(result.base, study.powers(result.nominal), study.powers(result.base.predicted)).is_steady
    return replace(result, moved=moved, parameter_gain=bool(moved) and pays)


def _rows(bench: ReplayBench, stretches: Sequence[Stretch]) -> Mask:
    rows = np.zeros(len(bench.measured), dtype=bool)
    for s in stretches:
        if s.recording in bench.lengths:
            rows[_slice(bench, s)] = True
    return rows


def _slice(bench: ReplayBench, s: Stretch) -> slice:
    first = bench.begin(s.recording)
    return slice(first + s.begin, first + min(s.end, bench.lengths[s.recording]))
