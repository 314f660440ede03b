"""The parts of a case over its recordings, with the models of its system or the corrected ones."""

from __future__ import annotations

from contextlib import closing
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from master import catalogue
from master.diagnosis.case.case import LoadedCase, read_case
from master.diagnosis.case.cut import CutPart, CutSystem, Values
from master.diagnosis.data.measured_signals import opened
from master.diagnosis.data.split_rows import split_of
from master.diagnosis.numerics.arrays import Array, Integers
from master.diagnosis.numerics.error_measures import errors
from master.diagnosis.replay.candidate_models import links
from master.diagnosis.replay.replay_bench import ReplayBench
from master.diagnosis.replay.replayer import Player
from master.errors import ConfigError
from master.fmi.description_reader import read_description
from master.fmi.values import parse
from master.system.config import LoadedConfig, read_config
from master.text.signal_name import SignalName

CORRECTED = "corrected"


@dataclass(frozen=True)
class Replayed:
    """One part over its recordings, shape (rows, outputs); `t` [s] is (rows,), `sealed` the sealed rows."""

    part: CutPart
    t: Array
    measured: Array
    predicted: Array
    sealed: Integers

    def errors(self) -> dict[str, Any]:
        """Errors on the sealed rows, by signal, as a diagnosis reports them."""
        return {
            name: asdict(errors(self.measured[self.sealed, i], self.predicted[self.sealed, i]))
            for i, name in enumerate(self.part.compared)
        }


def replay(path: Path, corrected: Path | None = None) -> dict[str, Replayed]:
    """
    Replay all parts of a case.

    Args:
        path: The case.
        corrected: A system whose FMUs and parameters take the place of those of the case's system.

    Returns:
        By the name of the part.

    Raises:
        ConfigError: If the case or the other system is wrong.
        FmuError: If an FMU cannot be loaded.
    """
    loaded = read_case(path)
    if corrected is not None and loaded.case.per_recording:
        problem = "corrected models hold one value of what every recording has for itself"
        where = loaded.where("per_recording")
        raise ConfigError([f"{where}: {problem}, got {loaded.case.per_recording}, expected none with --with"])
    system, recordings = opened(loaded)
    loaded = system.loaded
    other = None if corrected is None else read_config(corrected)
    stretches = split_of(loaded, recordings).sealed.open()
    fit = {s.recording for s in split_of(loaded, recordings).fit}
    results = {}
    for part in system.parts:
        files, values = _models(loaded, system, part, other)
        bench = ReplayBench(part, recordings, loaded.case, fitted=fit)
        with closing(Player(links(system, part, files))) as player:
            predicted = bench.predict(player, values)
        rows = [np.arange(s.begin, s.end) + bench.begin(s.recording) for s in stretches]
        sealed = np.concatenate(rows)
        sealed = sealed[sealed < len(bench.measured)]
        results[part.name] = Replayed(
            part=part,
            t=np.asarray(np.arange(len(bench.measured)) * bench.row_period, dtype=np.float64),
            measured=bench.measured,
            predicted=predicted,
            sealed=sealed[bench.in_use[sealed]],
        )
    return results


def corrected_system(path: Path, given: str) -> Path:
    """
    Find the corrected system of a case: a path, or `corrected` for the one in the usual folder of results.

    Raises:
        ConfigError: If there is none.
    """
    file = Path(given)
    if given == CORRECTED:
        folder = Path("results") / "diagnosis" / path.stem
        found = sorted(folder.glob("*_corrected.yaml"))
        file = found[0] if found else folder / f"{path.stem}_corrected.yaml"
    elif file.is_dir():
        found = sorted(file.glob("*_corrected.yaml"))
        file = found[0] if found else file / f"{path.stem}_corrected.yaml"
    if not file.is_file():
        raise ConfigError(
            [f"--with: no such system, got {file}, expected what `dockloop diagnose {path}` has written"]
        )
    return file


def _models(
    loaded: LoadedCase, system: CutSystem, part: CutPart, other: LoadedConfig | None
) -> tuple[dict[str, Path], Values]:
    """Files and values of the FMUs of a part."""
    values: Values = {fmu: dict(own) for fmu, own in system.values.items()}
    sources = dict(system.sources)
    folder = system.folder
    if other is not None:
        if other.problems:
            raise ConfigError(other.problems)
        folder = other.folder
        sources |= {fmu: entry.source for fmu, entry in other.config.fmus.items()}
    targets = {fmu: catalogue.locate(sources[fmu], folder, "native") for fmu in part.fmus}
    files = catalogue.files(targets, catalogue.silent)
    if other is None:
        return files, values
    for fmu in part.fmus:
        known = read_description(files[fmu]).by_name
        given = other.config.fmus[fmu].parameters
        values[fmu] |= {
            name: parse(known[name], value)
            for name, value in given.items()
            if name in known and not isinstance(value, list)
        }
    for key in loaded.case.set:  # what the case sets, it sets in the corrected system too
        fmu, variable = SignalName(key).parts
        values[fmu][variable] = system.values[fmu][variable]
    return files, values
