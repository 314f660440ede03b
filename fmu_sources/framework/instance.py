"""A model with numbers in it: set, initialise, step, read. Both FMI flavours behave like this class."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from .arithmetic import PYTHON, PythonArithmetic
from .integrate import MOST_SAMPLES, MOST_SUBSTEPS, n_substeps, runge_kutta_4
from .model import Fault, InputHold, Model
from .variables import Role

RELATIVE_STEP_TOLERANCE = 1e-9


class ModelError(ValueError):
    """A value or a step that the model refuses; the text names the variable, the value and the rule."""


class Instance:
    """
    One run of a model.

    `values` holds parameters, inputs, states and outputs in the order of `model.all_variables`.
    After `initialise`, `step(t, h)` takes the states from t [s] to t + h with the inputs in `values`.
    """

    def __init__(self, model: Model, m: PythonArithmetic = PYTHON) -> None:
        self.model = model
        self.m = m
        counts = [len(model.group(role)) for role in Role]
        ends = [sum(counts[: i + 1]) for i in range(len(counts))]
        self._p, self._u, self._x, self._y = (
            slice(end - count, end) for end, count in zip(ends, counts, strict=True)
        )
        self.index = {v.name: i for i, v in enumerate(model.all_variables)}
        self._samples = model.n_continuous < counts[2]
        self._restarting = [(i, v.start) for i, v in enumerate(model.all_variables) if v.restarts]
        self.reset()

    def reset(self) -> None:
        """Return to the start values."""
        self.values: list[Any] = [v.start for v in self.model.all_variables]
        self.previous_inputs = self.values[self._u]
        self.time = 0.0

    def __getitem__(self, name: str) -> Any:
        """Read a variable by name."""
        return self.values[self.index[name]]

    def __setitem__(self, name: str, value: float) -> None:
        """Set a variable by name; nothing is checked before `initialise` or `step`."""
        self.values[self.index[name]] = value

    def problems(self) -> list[str]:
        """List every parameter and input that breaks its rule."""
        found = []
        n_checked = self._u.stop
        for v, value in zip(self.model.all_variables[:n_checked], self.values, strict=False):
            rule = v.broken_rule(value)
            if rule is not None:
                unit = "" if v.unit == "1" else f" {v.unit}"
                found.append(f"{v.name}: value not allowed, got {value!r}{unit}, expected {rule}")
        return found

    def check(self) -> None:
        """Refuse parameters and inputs that break a rule."""
        problems = self.problems()
        if problems:
            raise ModelError("; ".join(problems))

    def initialise(self, t: float = 0.0) -> None:
        """Compute the states that follow from inputs and parameters, and the outputs at t [s]."""
        self.check()
        self._guarded(self._start, t)
        self._refuse_faults(t)
        self._refuse_non_finite(t)

    def step(self, t: float, h: float) -> None:
        """
        Step from t to t + h [s].

        Raises:
            ModelError: If h is not positive, holds no integer number of sampling periods, or too many parts;
                if an input breaks a rule or the model calls the result a fault.
        """
        self.check_inputs()
        n_samples, period = self._samples_of(h)
        self._guarded(self._advance, t, h, n_samples, period)
        self._refuse_faults(self.time)
        self._refuse_non_finite(self.time)

    def check_inputs(self) -> None:
        """Refuse inputs that are not finite; cheap, once a step."""
        if not math.isfinite(sum(self.values[self._u])):
            self.check()

    def _guarded(self, equations: Callable[..., None], t: float, *step: Any) -> None:
        try:
            equations(t, *step)
        except (ArithmeticError, ValueError) as error:
            raise ModelError(
                f"{self.model.name} at t={t!r} s: the equations have no result, {error}"
            ) from error

    def _start(self, t: float) -> None:
        p, u = self._record(self._p), self._record(self._u)
        x = self.model.states.record(self.values[self._x])
        starts = self.model.initial(x, u, p, self.m)
        self.values[self._x] = self.model.states.merged(starts, self.values[self._x])
        self.previous_inputs = self.values[self._u]
        self.time = t
        self._write_outputs(t)

    def _advance(self, t: float, h: float, n_samples: int, period: float) -> None:
        p, u = self._record(self._p), self._record(self._u)
        self.time = t + h
        for place, value in self._restarting:
            self.values[place] = value
        for i in range(n_samples):
            start = t + i * period
            if self._samples:
                self._update(start, u, p)
            if self.model.n_continuous:
                self._integrate(start, period, p, i / n_samples, 1.0 / n_samples)
            if i + 1 < n_samples and any(self._faults(start + period)):
                self.time = start + period
                break
        self.previous_inputs = self.values[self._u]
        self._write_outputs(self.time)

    def _record(self, place: slice) -> Any:
        kind = self.model.parameters if place is self._p else self.model.inputs
        return kind.record(self.values[place])

    def _samples_of(self, h: float) -> tuple[int, float]:
        if not 0.0 < h < math.inf:
            raise ModelError(f"communication step: not a positive number, got {h!r} s, expected above 0.0 s")
        n, period = self._periods_of(h)
        longest = self.model.substep
        is_endless = not period / longest <= MOST_SUBSTEPS + 0.5
        if self.model.n_continuous and (is_endless or n * n_substeps(period, longest) > MOST_SUBSTEPS):
            raise ModelError(
                f"communication step: too long, got {h!r} s, expected at most {MOST_SUBSTEPS} substeps of "
                f"{longest!r} s"
            )
        return n, period

    def _periods_of(self, h: float) -> tuple[int, float]:
        if self.model.sample_time is None:
            return 1, h
        period = self[self.model.sample_time]
        if not h / period < MOST_SAMPLES + 0.5:
            raise ModelError(
                f"communication step: too long for {self.model.sample_time}, got {h!r} s, "
                f"expected at most {MOST_SAMPLES} sampling periods of {period!r} s"
            )
        n = round(h / period)
        if n < 1 or abs(n * period - h) > RELATIVE_STEP_TOLERANCE * h:
            raise ModelError(
                f"communication step: not a multiple of {self.model.sample_time}, got {h!r} s, "
                f"expected a multiple of {period!r} s"
            )
        return n, period

    def _update(self, t: float, u: Any, p: Any) -> None:
        x = self.model.states.record(self.values[self._x])
        new = self.model.update(t, x, u, p, self.m)
        self.values[self._x] = self.model.states.merged(new, self.values[self._x])

    def _integrate(self, t: float, period: float, p: Any, first: float, share: float) -> None:
        n = n_substeps(period, self.model.substep)
        h = period / n
        n_c = self.model.n_continuous
        held = self.values[self._x][n_c:]
        derivatives = self.model.derivatives
        state = self.model.states.record
        flat = self.model.continuous.flat
        inputs = self._inputs_within_a_step()

        def h_times_derivatives(place: float, x: list[float]) -> list[float]:
            u = inputs(first + share * (place / n))
            return [h * d for d in flat(derivatives(t + place * h, state(x + held), u, p, self.m))]

        x = self.values[self._x][:n_c]
        self.values[self._x] = runge_kutta_4(h_times_derivatives, n, x) + held

    def _inputs_within_a_step(self) -> Callable[[float], Any]:
        """Return the inputs by the share of the communication step, 0 at its start, 1 at its end."""
        old = self.previous_inputs
        new = self.values[self._u]
        mode = self._hold()
        record = self.model.inputs.record
        if mode in (InputHold.hold_new, InputHold.hold_old):
            held = record(new if mode == InputHold.hold_new else old)
            return lambda _: held
        return lambda share: record([a + share * (b - a) for a, b in zip(old, new, strict=True)])

    def _hold(self) -> int:
        if self.model.input_hold is None:
            return InputHold.hold_new
        return int(self[self.model.input_hold])

    def _write_outputs(self, t: float) -> None:
        if not len(self.model.results):
            return
        x = self.model.states.record(self.values[self._x])
        y = self.model.outputs(t, x, self._record(self._u), self._record(self._p), self.m)
        self.values[self._y] = self.model.results.flat(y)

    def _faults(self, t: float) -> Sequence[Any]:
        if not self.model.fault_texts:
            return ()
        x = self.model.states.record(self.values[self._x])
        return self.model.faults(t, x, self._record(self._u), self._record(self._p), self.m)

    def _refuse_faults(self, t: float) -> None:
        found = zip(self.model.fault_texts, self._faults(t), strict=True)
        texts = [self._message(fault) for fault, is_true in found if is_true]
        if texts:
            raise ModelError("; ".join(texts))

    def _refuse_non_finite(self, t: float) -> None:
        """Refuse a state or output that is infinite or not a number; cheap, once a step."""
        first = self._x.start
        if math.isfinite(sum(self.values[first:])):
            return
        for v, value in zip(self.model.all_variables[first:], self.values[first:], strict=True):
            if not math.isfinite(value):
                raise ModelError(
                    f"{v.name}: value not finite at t={t!r} s, got {value!r}, expected a finite number"
                )

    def _message(self, fault: Fault) -> str:
        unit = self.model.all_variables[self.index[fault.variable]].unit
        value = f"{self[fault.variable]!r}" + ("" if unit == "1" else f" {unit}")
        return f"{fault.variable}: {fault.text}, got {value}, expected {fault.expected}"
