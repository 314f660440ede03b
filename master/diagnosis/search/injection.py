"""
What the outputs do when something is added in a slot: convolution with the answer to a step there.

The step is a constant offset in the slot from the start of a recording. One replay then gives the answer to
any number of functions of time, as long as the model is linear around its replay, and the same at all times:
twice the offset has to give twice the answer, and a law of the slot's signals the answer that the convolution
says. Around a large swing a pendulum passes the first test and fails the second.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from fmu_sources.effects.catalogue import candidates, constant
from fmu_sources.effects.framework.effect import Applied, Effect
from fmu_sources.effects.framework.roles import Signals
from fmu_sources.framework.array_arithmetic import ARRAYS
from fmu_sources.framework.model import Slot
from master.diagnosis.numerics.arrays import TINY, Array
from master.diagnosis.numerics.step_answers import convolved
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.text.signal_name import SignalName

from .study import Study

PROBE = 0.05  # offset over the rms of what is in the slot
LINEAR = 0.02  # largest departure from twice the answer, over the answer
SMOOTH = ("{value}/s", "{value}/{position}2")  # of a ramp in time, of a square of the position: units
WRONG = 1.0  # rms by which the answer to a law differs from the convolution, over its own: worse than none
NOTHING = 1e-12  # answers that are rounding, in the outputs' units over the offset's


class Injection:
    """Answers of a part's outputs to anything added in one slot (`fmu.slot`), around its base."""

    def __init__(self, study: Study, place: str, values: Mapping[str, float]) -> None:
        fmu, slot = SignalName(place).parts
        self.study = study
        self.offset = PlacedEffect(fmu, slot, constant().name)
        study.build([(self.offset,)])
        self.steps: dict[str, Array] = {}
        if not study.bench.is_windowed:
            self.steps = self._steps(values, PROBE * study.signal_rms(place).value)
        if self.steps and not self._is_same_at_all_times(place, values):
            self.steps = {}

    @property
    def is_linear(self) -> bool:
        """Whether the convolution holds."""
        return bool(self.steps)

    def answer(self, functions: Array) -> Array:
        """
        Scaled answers to functions of time.

        Args:
            functions: What is added, shape (samples, m).

        Returns:
            Shape (rows, outputs, m).
        """
        bench = self.study.bench
        first = 0
        answers = []
        for step in self.steps.values():
            own = functions[first : first + len(step)]
            first += len(step)
            outputs = [bench.compared(convolved(step[:, i], own)) for i in range(step.shape[1])]
            answers.append(np.stack(outputs, axis=1))
        return np.asarray(np.concatenate(answers) / self.study.output_scale[:, None])

    def _steps(self, values: Mapping[str, float], size: float) -> dict[str, Array]:
        """Answers to the offset over it, by recording, shape (samples, outputs); none if not linear."""
        name = self.offset.variable(self.offset.law.parameters[0].name)
        base = self.study.outputs((), values)
        once = self.study.outputs((self.offset,), {**values, name: size})
        twice = self.study.outputs((self.offset,), {**values, name: 2.0 * size})
        steps = {r: (once[r] - base[r]) / size for r in base}
        bent = max(float(np.abs((twice[r] - base[r]) / size - 2.0 * steps[r]).max()) for r in base)
        largest = max(float(np.abs(s).max()) for s in steps.values())
        return steps if np.isfinite(largest) and bent <= LINEAR * largest + NOTHING else {}

    def _is_same_at_all_times(self, place: str, values: Mapping[str, float]) -> bool:
        """Whether a law of the slot's signals is answered as the convolution says."""
        fmu, slot = SignalName(place).parts
        law = _probe(self.study.system.slots(fmu)[slot])
        if law is None:
            return True
        probe = PlacedEffect(fmu, slot, law.name)
        self.study.build([(probe,)])
        given = {probe.variable(name): v for name, v in law.scale(self.study.signal_rms(place)).items()}
        signals = self.study.signals[place]
        applied = applied_at_once(probe, given, signals, self.study.bench.times)
        said = self.answer((applied.value - signals["value"])[:, None])[..., 0]
        found = self.study.simulate((probe,), {**values, **given}) - self.study.simulate((), values)
        found /= self.study.output_scale
        apart = float(np.sqrt(np.nanmean((found - said) ** 2)))
        return apart <= WRONG * float(np.sqrt(np.nanmean(found**2))) + TINY


def applied_at_once(
    placed: PlacedEffect, values: Mapping[str, float], signals: Mapping[str, Array], times: Array
) -> Applied:
    """
    Evaluate a law without states on the signals of its slot.

    Args:
        placed: The effect.
        values: Its parameters by `fmu.variable`; those that are missing have their start values.
        signals: By role, shape (samples,) each.
        times: Of the samples [s].
    """
    law = placed.law
    own = Signals(**{role: v for role, v in signals.items() if role != "value"})
    p = law.parameter_record.record(parameters(placed, values))
    return law.law(times, signals["value"], own, law.state_record.record([]), p, ARRAYS)


def parameters(placed: PlacedEffect, values: Mapping[str, float]) -> list[float]:
    """Values of an effect's parameters in their order; start values where `values` has none."""
    return [float(values.get(placed.variable(v.name), v.start)) for v in placed.law.parameters]


def _probe(slot: Slot) -> Effect | None:
    """A smooth law without memory, of one coefficient; None if none fits."""
    plain = [law for law in candidates(slot) if not law.states and len(law.parameters) == 1]
    by_unit = {law.parameters[0].unit: law for law in plain}
    return next((by_unit[unit] for unit in SMOOTH if unit in by_unit), None)
