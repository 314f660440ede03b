"""
What the outputs do when something is added in a slot: convolution with the answer to a step there.

The step is a constant offset in the slot from the start of a recording. One replay then gives the answer to
any number of functions of time, as long as the model is linear around its replay: twice the offset has to
give twice the answer.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from fmu_sources.effects.catalogue import constant
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.numerics.step_answers import convolved
from master.diagnosis.replay.placed_effect import PlacedEffect
from master.text.signal_name import SignalName

from .study import Study

PROBE = 0.05  # offset over the rms of what is in the slot
LINEAR = 0.02  # largest departure from twice the answer, over the answer
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
