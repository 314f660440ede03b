"""Make recordings of the virtual rig and write them."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow
import pyarrow.parquet
from scipy.signal import chirp, lfilter

from .loop import T, run
from .parts import Effects, Plant, Recorder

NOMINAL = Plant()
COLUMNS = ("t", "s_des", "s_cmd", "s_act", "v_act", "f_des", "f_mea", "x", "s_exc")


@dataclass(frozen=True)
class Recording:
    """What a rig gives: named columns in SI units, nothing about the truth."""

    columns: dict[str, np.ndarray]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    def __len__(self) -> int:
        return len(self.columns["t"])

    def write(self, path: str | Path) -> Path:
        """Write CSV, NPZ or Parquet, by the ending of the name."""
        path = Path(path)
        if path.suffix == ".npz":
            np.savez(path, **self.columns)
        elif path.suffix == ".parquet":
            pyarrow.parquet.write_table(pyarrow.table(self.columns), path)
        else:
            with path.open("w", newline="") as file:
                writer = csv.writer(file)
                writer.writerow(self.columns)
                writer.writerows(zip(*(c.tolist() for c in self.columns.values()), strict=True))
        return path


def record(
    effects: Effects | None = None,
    *,
    excitation: str = "rich",
    seed: int = 1,
    duration: float = 10.0,
    s0: float = -5e-3,
    plant: Plant | tuple[Plant, Plant] = NOMINAL,
    recorder: Recorder | None = None,
) -> Recording:
    """
    Let the rig run.

    Args:
        effects: What is wrong with it; nothing if None.
        excitation: "decay" or "rich".
        seed: Of all noise.
        duration: [s]
        s0: Initial offset [m].
        plant: Parts of the rig; with a second one, that is what its compensator believes.
        recorder: Imperfections of the recording.

    Returns:
        Columns of duration/T rows, fewer if the loop left 1 m.
    """
    recorder = recorder or Recorder()
    true, believed = (plant, plant) if isinstance(plant, Plant) else plant
    t = np.arange(round(duration / T)) * T
    added = excited(excitation, t)
    noise = np.random.default_rng(seed).standard_normal((len(t), 3))
    noise[:, 0] = coloured(noise[:, 0], recorder.colour)
    parts = (true, believed, effects or Effects(), recorder)
    rows = run(*(type(part)(*map(float, part)) for part in parts), s0, added, noise)
    n = len(rows)
    values = [t[:n], *rows.T, np.zeros(n), added[:n]]
    return Recording({name: np.ascontiguousarray(v) for name, v in zip(COLUMNS, values, strict=True)})


def excited(kind: str, t: np.ndarray) -> np.ndarray:
    """Motion [m] that is added to the command, shape of t."""
    if kind == "decay":
        return np.zeros(len(t))
    if kind != "rich":
        raise ValueError(f"excitation: got {kind!r}, expected 'decay' or 'rich'")
    swept = chirp(t, 0.2, t[-1], 6.0, phi=-90.0)
    return 2e-3 * swept + 2e-3 * np.sin(2.0 * np.pi * 0.13 * t)


def coloured(white: np.ndarray, coefficient: float) -> np.ndarray:
    """Autoregressive noise of order 1 and unit variance."""
    gain = np.sqrt(1.0 - coefficient**2)
    start = np.array([coefficient * white[0] / gain]) if coefficient else np.zeros(1)
    return lfilter([gain], [1.0, -coefficient], white, zi=gain * start)[0]
