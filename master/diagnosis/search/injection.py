"""
What the outputs do when something is added in a slot: convolution with the answer to a step there.

    y(k) = S_0 u(k) + sum over n >= 1 of (S_n - S_(n-1)) (u(k-n) + u(k-n+1))/2

S is the answer to a constant offset in the slot from the start of a recording, over the offset. One replay
then gives the answer to any number of functions of time, as long as the model is linear around its replay:
twice the offset has to give twice the answer.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.signal import fftconvolve

from fmu_sources.effects.catalogue import constant
from master.diagnosis.numerics.arrays import Array
from master.diagnosis.replay.candidate_models import Added
from master.text.signal_name import SignalName

from .study import Study, merged

PROBE, LINEAR = 0.05, 0.02
NOTHING = 1e-12


class Injection:
    """Answers of a part's outputs to anything added in one slot (`fmu.slot`), around its base."""

    def __init__(self, study: Study, slot: str, values: Mapping[str, float]) -> None:
        fmu, name = SignalName(slot).parts
        self.study, self.added = study, Added(fmu, name, constant().name)
        study.pool.build([(self.added,)], study.progress)
        self.steps: dict[str, Array] = {}
        if not study.bench.is_windowed:
            self.steps = self._steps(values, PROBE * study.sizes(slot).value)

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
        bench, at, found = self.study.bench, 0, []
        for step in self.steps.values():
            own = functions[at : at + len(step)]
            at += len(step)
            outputs = [bench.compared(_convolved(step[:, i], own)) for i in range(step.shape[1])]
            found.append(np.stack(outputs, axis=1))
        return np.asarray(np.concatenate(found) / self.study.size[:, None])

    def _steps(self, values: Mapping[str, float], size: float) -> dict[str, Array]:
        study, name = self.study, f"{self.added.fmu}.{self.added.prefix}_{self.added.law.constant}"
        base, once, twice = (
            study.bench.replayed(player, merged(study.system.values, dict(values) | given))
            for player, given in (
                (study.pool.player(()), {}),
                (study.pool.player((self.added,)), {name: size}),
                (study.pool.player((self.added,)), {name: 2.0 * size}),
            )
        )
        steps = {r: (once[r] - base[r]) / size for r in base}
        bent = max(float(np.abs((twice[r] - base[r]) / size - 2.0 * steps[r]).max()) for r in base)
        largest = max(float(np.abs(s).max()) for s in steps.values())
        return steps if np.isfinite(largest) and bent <= LINEAR * largest + NOTHING else {}


def _convolved(step: Array, functions: Array) -> Array:
    """Answer of one output to functions (samples, m)."""
    n = len(step)
    later = np.diff(step)
    if np.abs(later).max() <= 1e-9 * abs(step[0]):
        return np.asarray(step[0] * functions)
    means = 0.5 * (functions[1:] + functions[:-1])
    found = step[0] * functions
    found[1:] += fftconvolve(means, later[:, None], axes=0)[: n - 1]
    return np.asarray(found)
