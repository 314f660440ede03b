"""
Runs of a system in its fused form: a library of its FMUs' sources and schedule that makes a run in one call.

A run here has the bits of `simulate`. What an FMU refuses is not told here: such a run is to be made again
with the FMUs themselves, which say what is wrong.
"""

from __future__ import annotations

import ctypes
import hashlib
import platform
import time
from collections.abc import Collection, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fmu_sources.export import native
from master.errors import ConfigError
from master.experiment.experiment import Experiment
from master.installation import cache_folder
from master.process import position
from master.recording.recorder import Floats, Result
from master.recording.whole_file import write_whole
from master.stepping.limit_monitor import ends_a_run, largest_magnitude, used_signals, what_is_beyond
from master.stepping.outcome import COMPLETED, DIVERGED, Outcome
from master.stepping.recorded import recorded_ports
from master.system.graph import Instance

from .export import fused_system
from .layout import OUTPUT, Fused
from .sources import run_sources

REFUSED = "refused by an FMU, which says itself what is wrong"
OTHER_SYSTEM = "the fused form is of another system"
OTHER_START = "a start value that the fused form does not take"
"""Why a run is not made in the fused form."""

_NAME = "runs"


@dataclass(frozen=True)
class FusedForm:
    """
    A system as a library that makes whole runs of it.

    `library` is where it is, or will be; `start` are the start values of parameters, inputs and states as the
    library takes them, `places` the places in it of those that may be set, by `instance.variable`.
    """

    library: Path
    start: Floats
    places: Mapping[str, int]

    def require(self, signals: Collection[str]) -> None:
        """
        See that start values of these signals can be set.

        Raises:
            ConfigError: With those that cannot, as a connection replaces them.
        """
        others = sorted(signal for signal in signals if signal not in self.places)
        if others:
            raise ConfigError([f"start values that a connection replaces: {', '.join(others)}"])

    def start_of(self, instances: Mapping[str, Instance]) -> Floats | None:
        """Return the start values of a run; None if they are not all among those that may be set."""
        start = self.start.copy()
        for name, instance in instances.items():
            for variable, value in instance.start.items():
                place = self.places.get(f"{name}.{variable}")
                if place is None or isinstance(value, str):
                    return None
                start[place] = value
        return start if np.isfinite(start).all() else None


class Draft:
    """A fused form whose library may not have been compiled yet, and the compiler that is at work on it."""

    def __init__(self, form: FusedForm, sources: Mapping[str, bytes]) -> None:
        self.form = form
        self._sources = sources
        self._compilation: native.Compilation | None = None

    @property
    def is_compiled(self) -> bool:
        """Whether the library is in the cache."""
        return self.form.library.is_file()

    def begin(self) -> None:
        """
        Let a compiler begin.

        Raises:
            ConfigError: If this machine has none, or no room for its files.
        """
        try:
            self._compilation = native.begin_host(self._sources, _NAME)
        except (native.NativeBuildError, OSError) as error:
            raise ConfigError([str(error)]) from None

    def is_done(self) -> bool:
        """Whether a compiler has begun and ended."""
        return self._compilation is not None and self._compilation.is_done()

    def keep(self) -> None:
        """
        Put what the compiler made into the cache; waits for it.

        Raises:
            ConfigError: If it failed, or the cache cannot be written.
        """
        assert self._compilation is not None, "no compiler has begun"
        try:
            write_whole(self.form.library, self._compilation.library())
        except native.NativeBuildError as error:
            raise ConfigError([str(error)]) from None
        except OSError as error:
            raise ConfigError([f"{self.form.library}: cannot be written, got {error}"]) from None

    def close(self) -> None:
        """End the compiler if it is at work still."""
        if self._compilation is not None:
            self._compilation.close()
            self._compilation = None


def _what_a_master_does(experiment: Experiment) -> list[str]:
    """Say what of a system's runs only a master does, besides what an exported system refuses."""
    found = []
    if experiment.inputs.columns:
        found.append("inputs come from a recording")
    if experiment.scenario.stops:
        found.append("stop_when ends runs")
    isolated = [i.name for i in experiment.system.instances.values() if i.isolation is not None]
    if isolated:
        found.append(f"{', '.join(isolated)} in a process of its own")
    return found


def draft_of(experiment: Experiment) -> Draft:
    """
    Generate the fused form of a system.

    Raises:
        ConfigError: With every reason why the system has none.
    """
    problems = _what_a_master_does(experiment)
    if problems:
        raise ConfigError(problems)
    fused = fused_system(experiment)
    files = run_sources(fused, recorded_ports(experiment.system))
    told = hashlib.sha256(" ".join([platform.platform(), *native.CODE_FLAGS]).encode())
    for name, content in files.items():
        told.update(f"\0{name}\0".encode() + content)
    library = cache_folder() / "fused" / f"{told.hexdigest()}.so"
    form = FusedForm(library, *_start(fused))
    form.require([f"{i.name}.{v}" for i in fused.system.instances.values() for v in i.start])
    return Draft(form, files)


def fused_form(experiment: Experiment) -> FusedForm:
    """
    Return the fused form of a system, compiled if its library is not in the cache.

    Raises:
        ConfigError: With every reason why it has none, or why it cannot be compiled here.
    """
    with closing(draft_of(experiment)) as draft:
        if not draft.is_compiled:
            draft.begin()
            draft.keep()
        return draft.form


def _start(fused: Fused) -> tuple[Floats, dict[str, int]]:
    """Start values of all but outputs, and the places of those that may be set."""
    taken = [v for v in fused.variables if v.role != OUTPUT]
    places = {v.name: i for i, v in enumerate(taken) if v.has_start}
    return np.array([v.start for v in taken], dtype=np.float64), places


class _Chosen(ctypes.Structure):
    """Signals by their places in a row of all."""

    _fields_ = (("places", ctypes.c_void_p), ("n", ctypes.c_int64))


class _Ended(ctypes.Structure):
    """After how many ticks a run ended, which watched signal was beyond its limit, or -1, and its value."""

    _fields_ = (("ticks", ctypes.c_int64), ("beyond", ctypes.c_int64), ("value", ctypes.c_double))


def _chosen(places: NDArray[np.int64]) -> _Chosen:
    return _Chosen(places.ctypes.data, len(places))


class FusedRuns:
    """
    Makes runs of one system whose FMUs' start values may differ.

    Raises:
        OSError: If the library cannot be loaded.
        MemoryError: If there is no room for an instance.
    """

    def __init__(self, form: FusedForm, base: Experiment, kept: Collection[str] | None = None) -> None:
        """
        Load the library.

        Args:
            form: The fused form.
            base: The system.
            kept: Recorded signals that the rows are to hold, None for all.
        """
        self._form = form
        self._base = base
        self._ports = ports = recorded_ports(base.system)
        self._library = _loaded(form.library)
        self._instance = self._library.runs_open()
        if not self._instance:
            raise MemoryError(f"no memory for an instance of {base.title}")
        conditions = [e.condition.signal for e in base.scenario.events if e.condition is not None]
        used = used_signals(base.system, base.limits, base.compared, conditions)
        self._kept = [i for i, p in enumerate(ports) if kept is None or p.name in kept]
        self._watched = [i for i, p in enumerate(ports) if ends_a_run(p, base.limits, used)]
        self._limits = np.array([largest_magnitude(ports[i], base.limits) for i in self._watched])
        self._kept_places = np.array(self._kept, dtype=np.int64)
        self._watched_places = np.array(self._watched, dtype=np.int64)
        self._names = tuple(ports[i].name for i in self._kept)
        self._units = tuple(ports[i].variable.unit_name for i in self._kept)
        self._rows: Floats = np.empty((0, len(self._kept)))

    def run(self, experiment: Experiment) -> Outcome | str:
        """
        Make a run; the rows of the outcome are good until the next one.

        Where it is to be made with the FMUs themselves, return why.

        Raises:
            MemoryError: If there is no room for the rows.
        """
        if not self._is_mine(experiment):
            return OTHER_SYSTEM
        start = self._form.start_of(experiment.system.instances)
        if start is None:
            return OTHER_START
        grid = experiment.grid
        position.current().begin(grid.t0, grid.step_size)
        if len(self._rows) <= grid.n_ticks:
            self._rows = np.empty((grid.n_ticks + 1, len(self._kept)))
        ended = _Ended()
        began = time.perf_counter()
        is_done = self._library.runs_make(
            self._instance,
            start.ctypes.data,
            grid.t0,
            grid.n_ticks,
            ctypes.byref(_chosen(self._kept_places)),
            ctypes.byref(_chosen(self._watched_places)),
            self._limits.ctypes.data,
            self._rows.ctypes.data,
            ctypes.byref(ended),
        )
        seconds = time.perf_counter() - began
        if not is_done:
            return REFUSED
        n_rows = ended.ticks + 1
        time_of_rows = grid.t0 + np.arange(n_rows).astype(np.float64) * grid.step_size
        result = Result(time_of_rows, self._names, self._units, self._rows[:n_rows])
        if ended.beyond < 0:
            return Outcome(COMPLETED, result, seconds, ended.ticks)
        return Outcome(DIVERGED, result, seconds, ended.ticks, cause=self._cause(ended))

    def close(self) -> None:
        """Free the memory of the system."""
        self._library.runs_close(self._instance)
        self._instance = None

    def _is_mine(self, experiment: Experiment) -> bool:
        base = self._base
        return (
            experiment.system.wires is base.system.wires
            and experiment.schedule is base.schedule
            and experiment.config is base.config
        )

    def _cause(self, ended: _Ended) -> str:
        """Say which signal ended the last run."""
        port = self._ports[self._watched[ended.beyond]]
        return what_is_beyond(port, ended.value, float(self._limits[ended.beyond]))


def _loaded(path: Path) -> ctypes.CDLL:
    library = ctypes.CDLL(str(path))
    library.runs_open.restype = ctypes.c_void_p
    library.runs_close.argtypes = [ctypes.c_void_p]
    library.runs_close.restype = None
    library.runs_make.argtypes = [
        ctypes.c_void_p,
        ctypes.c_void_p,
        ctypes.c_double,
        ctypes.c_int64,
        ctypes.POINTER(_Chosen),
        ctypes.POINTER(_Chosen),
        ctypes.c_void_p,
        ctypes.c_void_p,
        ctypes.POINTER(_Ended),
    ]
    library.runs_make.restype = ctypes.c_bool
    return library
