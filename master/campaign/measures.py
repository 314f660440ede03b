"""Numbers of one run: metrics of `compare`, and the campaign's own measures."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import trapezoid

from master.errors import ConfigError, Problem
from master.evaluation.metrics import metrics_on_this_thread
from master.recording.recorder import Result
from master.runs.execute import rows_in_memory
from master.system.config import Compare

from .campaign import Measure

Floats = NDArray[np.float64]
Function = Callable[[Floats, Mapping[str, Floats]], float]


def metrics(
    result: Result, compare: Compare | None, names: tuple[str, ...], n_recorded: int
) -> dict[str, float | None]:
    """Compute metrics by name as `dockloop run` does, which keeps rows of `n_recorded` signals."""
    if not names or compare is None:
        return dict.fromkeys(names)
    every = math.ceil((len(result.time) - 1) / rows_in_memory(n_recorded)) or 1
    kept = result if every == 1 else replace(result, time=result.time[::every], values=result.values[::every])
    found = metrics_on_this_thread(kept, compare)
    return {name: found[name] for name in names}


def measured(measure: Measure, result: Result, function: Function | None) -> float | None:
    """
    Compute a measure; None where it has no finite value.

    Raises:
        Exception: Whatever a function of the user raises.
    """
    rows = _rows(measure, result.time)
    time = result.time[rows]
    if len(time) == 0:
        return None
    if function is not None:
        signals = {name: result[name][rows] for name in result.names}
        return _finite(function(time, signals))
    values = result[measure.signals[0]][rows]
    with np.errstate(all="ignore"):
        match measure.kind:
            case "first_crossing":
                return _first_crossing(time, values, measure)
            case "settling_time":
                return _settling_time(time, values, measure)
            case "energy":
                return _finite(trapezoid(values * result[str(measure.other)][rows], time))
            case "rms":
                return _finite(np.sqrt(np.mean(values * values)))
            case "largest":
                return _finite(np.max(np.abs(values)))
            case "final":
                return _finite(values[-1])
            case "mean":
                return _finite(np.mean(values))
            case "minimum":
                return _finite(np.min(values))
    return _finite(np.max(values))


def _rows(measure: Measure, time: Floats) -> slice:
    """Rows from `from` to `to`, both included, with room for rounding of times."""
    room = 1e-9 * max(1.0, float(np.max(np.abs(time), initial=0.0)))
    begin = 0 if measure.begin is None else int(np.searchsorted(time, measure.begin - room))
    end = len(time) if measure.end is None else int(np.searchsorted(time, measure.end + room, side="right"))
    return slice(begin, end)


def _first_crossing(time: Floats, values: Floats, measure: Measure) -> float | None:
    """Time at which the line between two rows first crosses the level."""
    above = values > measure.level
    if measure.direction == "rising":
        crossed = ~above[:-1] & above[1:]
    elif measure.direction == "falling":
        crossed = above[:-1] & ~above[1:]
    else:
        crossed = above[:-1] != above[1:]
    if not crossed.any():
        return None
    k = int(np.argmax(crossed))
    share = (measure.level - values[k]) / (values[k + 1] - values[k])
    return _finite(time[k] + share * (time[k + 1] - time[k]))


def _settling_time(time: Floats, values: Floats, measure: Measure) -> float | None:
    """Time of the first row after which no row is out of the band; None if the last one is out of it."""
    outside = ~(np.abs(values - measure.level) <= (measure.band or 0.0))
    if outside[-1]:
        return None
    last = np.flatnonzero(outside)
    return float(time[0] if len(last) == 0 else time[last[-1] + 1])


def _finite(value: Any) -> float | None:
    number = float(value)
    return number if math.isfinite(number) else None


def load_function(text: str, folder: Path) -> Function:
    """
    Load a function from `file.py:name`, the file relative to the campaign's folder.

    Raises:
        ConfigError: If there is none.
    """
    file, _, name = text.rpartition(":")
    path = folder / file
    if not file or not path.is_file():
        expected = "file.py:name of a Python file next to the campaign"
        raise ConfigError([Problem("no such file", got=repr(text), expected=expected)])
    spec = importlib.util.spec_from_file_location(f"dockloop_measure_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # whatever the file of the user does
        raise ConfigError(
            [Problem(f"cannot be loaded: {type(error).__name__}: {error}", got=repr(text))]
        ) from None
    found = getattr(module, name, None)
    if not callable(found):
        names = sorted(n for n, v in vars(module).items() if callable(v) and not n.startswith("_"))
        raise ConfigError(
            [Problem("no such function", got=repr(text), expected=f"one of {', '.join(names) or 'none'}")]
        )
    return found  # type: ignore[no-any-return]
