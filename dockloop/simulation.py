"""A system step by step: read, set, step, save, restore."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from master.errors import ConfigError, Problem
from master.experiment.experiment import Experiment
from master.stepping.opened import OpenRun, RunState

from .result import Run
from .values import plain


@dataclass(frozen=True)
class SavedState:
    """State of a simulation at `t` [s]; `Simulation.restore` goes back to it, as often as wanted."""

    t: float
    state: RunState

    def __repr__(self) -> str:
        return f"<SavedState at t = {self.t:g} s>"


class Simulation:
    """
    A system that is open; made by `System.open`. Use it in a `with` block, or call `close`.

    `sim["instance.variable"]` reads any variable at the present time, in its own unit. After a step the
    outputs are those at `t`; the inputs are those that the step used.
    """

    def __init__(self, experiment: Experiment, opened: OpenRun, values: Mapping[str, Any]) -> None:
        self._experiment = experiment
        self._opened = opened
        self._values = dict(values)

    @property
    def t(self) -> float:
        """Present time [s]."""
        return self._opened.grid.time(self._opened.tick)

    @property
    def status(self) -> str:
        """`running`, or how it ended: `completed`, `diverged`, `stopped`, `terminated`, `failed`."""
        if self._opened.ended is not None:
            return self._opened.ended.status
        return "completed" if self._opened.tick >= self._opened.grid.n_ticks else "running"

    @property
    def is_done(self) -> bool:
        """Whether it cannot step any further."""
        return self.status != "running"

    def step(self, n: int = 1) -> None:
        """
        Step by n ticks; fewer if the run ends on the way, which `status` says then.

        Raises:
            ConfigError: If it is closed, has ended or is at its stop time, or n is not a positive integer.
            FmuError: If an FMU or a block fails; rows before it are in `result()`.
        """
        if isinstance(n, bool) or not isinstance(n, int) or n < 1:
            raise ConfigError([Problem("ticks", where="step", got=repr(n), expected="a positive integer")])
        if self.status == "completed":
            problem = Problem(
                "at the stop time", where=f"t={self.t:.9g} s", expected="open(stop_time=...) later"
            )
            raise ConfigError([problem])
        self._opened.step(n)

    def __getitem__(self, signal: str) -> float:
        """Value of `instance.variable` now; ConfigError with the nearest name if there is none."""
        return self._opened.get(signal)

    def set(self, signal: str, value: Any) -> None:
        """
        Set a tunable parameter or an input that is not connected, in its own unit; the next step uses it.

        Raises:
            ConfigError: If there is no such variable, it cannot be set now, or refuses the value.
            FmuError: If the FMU refuses.
        """
        self._opened.set(signal, plain(value))

    def save(self) -> SavedState:
        """
        Keep the state of all FMUs and connections.

        Raises:
            ConfigError: With each FMU that cannot save its state.
        """
        return SavedState(self.t, self._opened.save())

    def restore(self, state: SavedState) -> None:
        """
        Go back to a state that was saved here; rows after it are forgotten.

        Raises:
            ConfigError: If it was saved by another simulation, or an FMU has failed since.
        """
        self._opened.restore(state.state)

    def result(self) -> Run:
        """Return all rows up to now as a `Run`; it stays as it is when the simulation goes on."""
        return Run(self._experiment, self._opened.outcome(), self._values)

    def close(self) -> None:
        """End the FMUs."""
        self._opened.close()

    def __enter__(self) -> Simulation:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Simulation of {self._experiment.title}: {self.status} at t = {self.t:g} s>"
