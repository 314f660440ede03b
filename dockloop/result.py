"""What a run computed: rows, metrics, how it ended."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from master.errors import ConfigError, Problem, nearest
from master.experiment.experiment import Experiment
from master.stepping.outcome import Outcome

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]


class Run:
    """
    A run that has ended.

    Attributes:
        name: Name of the system.
        variant: Variant that was run; None for the file as it is.
        values: What was set over the file, `instance.variable` to value.
        status: `completed`, `diverged`, `stopped` (by `stop_when`), `terminated` (an FMU asked for the end),
            `interrupted`; a run in which an FMU failed raises `FmuError` instead.
        message: Why it ended early; empty if it did not.
        time: Times of the rows [s], shape (rows,); row k is at t0 + k h, row 0 the initial state.
        steps: Steps done.
        seconds: Time of stepping alone [s].
        notes: What should be known before the run; `warnings` and `messages` (of FMUs) of the run itself.
    """

    def __init__(
        self, experiment: Experiment, outcome: Outcome, values: Mapping[str, Any] | None = None
    ) -> None:
        self._experiment = experiment
        self._outcome = outcome
        self.values = dict(values or {})
        self.name = experiment.name
        self.variant = experiment.variant
        self.status = outcome.status
        self.message = outcome.cause or ("" if outcome.error is None else str(outcome.error))
        self.time: Floats = outcome.result.time
        self.steps = outcome.steps
        self.seconds = outcome.seconds
        self.notes = list(experiment.notes)
        self.warnings = list(outcome.warnings)
        self.messages = [asdict(said) for said in outcome.messages]
        self.not_reached = list(outcome.not_reached)
        self.happened = [asdict(happened) for happened in outcome.happened]

    @property
    def signals(self) -> tuple[str, ...]:
        """Names of all recorded signals, `instance.variable`."""
        return self._outcome.result.names

    def __getitem__(self, signal: str) -> Floats:
        """One signal, shape (rows,); KeyError with the nearest name if it was not recorded."""
        try:
            return self._outcome.result[signal]
        except KeyError:
            raise KeyError(
                f"no such signal, got {signal!r}, expected {nearest(signal, self.signals)}"
            ) from None

    def __contains__(self, signal: object) -> bool:
        return signal in self.signals

    def __len__(self) -> int:
        return len(self.time)

    def unit(self, signal: str) -> str:
        """Unit of a signal, `1` if it has none."""
        self[signal]
        return self._outcome.result.unit(signal)

    @property
    def units(self) -> dict[str, str]:
        """Units of all signals."""
        return dict(zip(self.signals, self._outcome.result.units, strict=True))

    @cached_property
    def metrics(self) -> dict[str, float | None]:
        """
        Numbers that the run is judged by, for a system with a section `compare`; else empty.

        zeta, frequency [Hz], growth_per_cycle, rms_s_des, rms_s_act (relative to the offset), phase_deg,
        zeta_reference, frequency_reference [Hz]; None where nothing oscillates.
        """
        compare = self._experiment.compare
        if compare is None:
            return {}
        from master.evaluation.metrics import compute_metrics

        return compute_metrics(self._outcome.result, compare)

    def to_pandas(self) -> Any:
        """
        Return a `pandas.DataFrame`: index `time` [s], a column a signal, units in `attrs["units"]`.

        Raises:
            ConfigError: If pandas is not installed.
        """
        from master.installation import NOTEBOOK, require

        require(NOTEBOOK, "to_pandas", ["pandas"])
        import pandas as pd

        index = pd.Index(self.time, name="time")
        frame = pd.DataFrame(self._outcome.result.values, index=index, columns=list(self.signals))
        frame.attrs = {"units": {"time": "s", **self.units}, **self._about()}
        return frame

    def to_xarray(self) -> Any:
        """
        Return an `xarray.Dataset` over `time` [s]; each variable has its unit in `attrs["units"]`.

        Raises:
            ConfigError: If xarray is not installed.
        """
        from master.installation import NOTEBOOK, require

        require(NOTEBOOK, "to_xarray", ["xarray"])
        import xarray as xr

        columns = {
            name: ("time", self[name], {"units": unit, "long_name": name})
            for name, unit in self.units.items()
        }
        time = {"time": ("time", self.time, {"units": "s"})}
        return xr.Dataset(columns, coords=time, attrs={k: str(v) for k, v in self._about().items() if v})

    def plot(self, *signals: str) -> Figure:
        """
        Draw signals over time, one axis a unit, units on the axes.

        Args:
            signals: What is drawn; by default what the system compares, else all.

        Returns:
            A figure that belongs to no window; a notebook shows it, `savefig` writes it.

        Raises:
            KeyError: If a signal was not recorded.
        """
        from .figure import ShownFigure

        chosen = signals or self._compared() or self.signals
        by_unit: dict[str, list[str]] = {}
        for name in chosen:
            by_unit.setdefault(self.unit(name), []).append(name)
        figure = ShownFigure(figsize=(8.0, 1.0 + 2.2 * len(by_unit)), layout="constrained")
        axes = figure.subplots(len(by_unit), 1, sharex=True, squeeze=False)[:, 0]
        for axis, (unit, names) in zip(axes, by_unit.items(), strict=True):
            for name in names:
                axis.plot(self.time, self[name], label=name)
            axis.set_ylabel("value [1]" if unit == "1" else f"[{unit}]")
            axis.legend(loc="upper right", fontsize="small")
            axis.grid(alpha=0.3)
        axes[-1].set_xlabel("time [s]")
        figure.suptitle(f"{self._experiment.title}: {self.status}")
        from master.pages.plain_text import as_written

        as_written(figure)
        return figure

    def save(self, folder: str | Path) -> dict[str, Path]:
        """
        Write `result.csv` and `result.parquet` (units in the fields' metadata) into a folder.

        What the system's section `record` names is written, all if it has none.

        Raises:
            ConfigError: If they cannot be written.
        """
        from master.recording.files import write_result
        from master.recording.folder import CSV, PARQUET, reason

        folder = Path(folder)
        try:
            write_result(self._experiment.selection.of(self._outcome.result), folder)
        except OSError as error:
            raise ConfigError([Problem(f"cannot be written: {reason(error)}", where=str(folder))]) from None
        return {"csv": folder / CSV, "parquet": folder / PARQUET}

    def as_dict(self) -> dict[str, Any]:
        """All but the rows, as `dockloop run --json` prints it."""
        return {
            **self._about(),
            "t_end": float(self.time[-1]) if len(self.time) else None,
            "steps": self.steps,
            "metrics": dict(self.metrics),
            "warnings": self.warnings,
            "notes": self.notes,
            "messages": self.messages,
            "not_reached": self.not_reached,
            "happened": self.happened,
        }

    def _about(self) -> dict[str, Any]:
        return {
            "name": self.name,
            "variant": self.variant,
            "status": self.status,
            "set": dict(self.values),
            "message": self.message,
        }

    def _compared(self) -> Iterable[str]:
        return [name for name in self._experiment.compared if name in self]

    def __repr__(self) -> str:
        end = f"t = {self.time[-1]:g} s" if len(self.time) else "the start"
        said = f": {self.message}" if self.message else ""
        return f"<Run {self._experiment.title}: {self.status} at {end}, {len(self.signals)} signals{said}>"

    def _repr_html_(self) -> str:
        shown = {
            "status": self.status,
            "message": self.message,
            "set": self.values or "",
            "steps": self.steps,
        }
        shown |= {k: f"{v:.6g}" for k, v in self.metrics.items() if v is not None}
        rows = "".join(
            f"<tr><th style='text-align:left'>{escape(str(k))}</th><td>{escape(str(v))}</td></tr>"
            for k, v in shown.items()
            if v != ""
        )
        return f"<b>{escape(self._experiment.title)}</b><table>{rows}</table>"
