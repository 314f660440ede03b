"""Measured inputs that no connection of a system drives, as a file that a run reads."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from master.diagnosis.case.cut import CutSystem
from master.diagnosis.data.recordings import Recording

TIME = "time"


def driven_inputs(system: CutSystem, wired: Iterable[str]) -> dict[str, tuple[str, str]]:
    """Measured inputs `fmu.variable` without a connection: their signal, and the row it is taken from."""
    taken = set(wired)
    return {
        f"{fmu}.{variable}": (measured.signal, measured.row)
        for part in system.parts
        for fmu, inputs in part.inputs.items()
        for variable, measured in inputs.items()
        if f"{fmu}.{variable}" not in taken
    }


def write_inputs(path: Path, inputs: Mapping[str, tuple[str, str]], recording: Recording) -> dict[str, Any]:
    """
    Write what drives a system over one recording as Parquet, and return what the system says of it.

    A run takes an input from the end of each step; one that a replay takes from its start is a row later.
    """
    n = len(recording)
    columns: dict[str, Any] = {TIME: np.arange(n) * recording.period}
    for key, (signal, row) in inputs.items():
        values = recording[signal]
        columns[key] = values if row == "end" else np.concatenate([values[:1], values[:-1]])
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(pa.table(columns), path)
    return {
        "step_size": recording.period,
        "stop_time": (n - 1) * recording.period,
        "inputs": [
            {
                "file": f"./{path.name}",
                "time": {"column": TIME, "unit": "s"},
                "map": {key: {"column": key} for key in inputs},
            }
        ],
    }
