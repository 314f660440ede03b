"""Systems: loaded from a file, a dict or an SSP; run, swept, opened step by step, analysed, written."""

from __future__ import annotations

import itertools
import json
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping
from html import escape
from pathlib import Path
from typing import Any

from master.api import prepare_to_run
from master.catalogue import silent
from master.errors import ConfigError, Problem, nearest
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request
from master.fmi import unpacked
from master.fmi.description import Description
from master.fmi.slave import Slave
from master.fmi.unit_names import unit as unit_of_name
from master.fmi.units import conversion
from master.installation import configuration, shipped_configurations
from master.ssp.names import SUFFIXES
from master.stepping.opened import WORKING, OpenRun
from master.stepping.outcome import FAILED, INTERRUPTED, RunOptions
from master.stepping.simulate import load as load_fmu
from master.stepping.simulate import simulate
from master.system.config import Config, LoadedConfig, read_config
from master.text.validation import validate
from master.text.yaml_lines import parse_yaml

from .python_block import Block, BlockSlave
from .result import Run
from .simulation import Simulation
from .values import plain

Source = str | Path | Mapping[str, Any]
Values = Mapping[str, Any]
Progress = Callable[[float], None]
_BLOCK = "block"


def configurations() -> tuple[str, ...]:
    """Names of the configurations that are shipped, for `load`."""
    return tuple(shipped_configurations())


def load(source: Source, *, blocks: Mapping[str, Block] | None = None, flavour: str = "native") -> System:
    """
    Load a system; every fault of it is said here, no FMU is loaded yet.

    Args:
        source: Name of a shipped configuration (`configurations()`), path of a YAML file or an SSP archive,
            or the content of such a YAML file as a dict; relative paths of a dict start from the working
            folder, and a `source` of its `fmus` may be a `Block`.
        blocks: Instance name to a Python block that takes the place of the FMU in the file.
        flavour: Which FMU a model's name means: `native` (FMI 2.0), `fmi3`, or `python`.

    Raises:
        ConfigError: With all faults; `problems` has `where`, `what`, `got`, `expected` of each.
    """
    return System(source, blocks=blocks, flavour=flavour)


class System:
    """
    A system of FMUs and Python blocks; made by `load`. Nothing that is done with it changes it.

    FMUs stay unpacked as long as the system exists, so that its second run starts sooner.
    """

    def __init__(
        self, source: Source, *, blocks: Mapping[str, Block] | None = None, flavour: str = "native"
    ) -> None:
        """Read and check; see `load`."""
        self._blocks = dict(blocks or {})
        self._flavour = flavour
        self._source = self._read(source)
        self._prepared: dict[Request, Experiment] = {}
        self._folders: dict[Path, str] = {}
        self._experiment = self._prepare(Request(flavour=flavour))
        weakref.finalize(self, _release, self._folders)

    @property
    def name(self) -> str:
        """Name of the system."""
        return self._experiment.name

    @property
    def variants(self) -> tuple[str, ...]:
        """Names of its variants, for `run(variant=...)`."""
        return tuple(self._experiment.config.variants)

    @property
    def step_size(self) -> float:
        """Length of a tick [s]."""
        return self._experiment.grid.step_size

    @property
    def stop_time(self) -> float:
        """End of a run [s]."""
        return self._experiment.config.stop_time

    @property
    def notes(self) -> list[str]:
        """What should be known before a run: algebraic loops, start values that break their own rules."""
        return self._experiment.notes

    @property
    def fmus(self) -> dict[str, Path]:
        """Instance name to the FMU's file; of a block a name that says so."""
        return {name: i.description.path for name, i in self._experiment.system.instances.items()}

    @property
    def connections(self) -> list[tuple[str, str]]:
        """Pairs (from, to) of `instance.variable`."""
        return [(w.source.name, w.target.name) for w in self._experiment.system.wires]

    def signals(self, causality: str | None = None) -> dict[str, str]:
        """
        Map `instance.variable` to its unit.

        Args:
            causality: `input`, `output`, `parameter`, `local`, ...; all by default.
        """
        return {
            f"{name}.{v.name}": v.unit_name
            for name, instance in self._experiment.system.instances.items()
            for v in instance.description.variables
            if causality in (None, v.causality)
        }

    def delays(self) -> list[dict[str, Any]]:
        """Age of the value on each connection: `from`, `to`, `steps`, `seconds` (and the target's own)."""
        entries = self._experiment.ledger.entries
        return [{"from": e.source, "to": e.target, "steps": e.mean, "seconds": e.seconds} for e in entries]

    def run(
        self,
        variant: str | None = None,
        *,
        set: Values | None = None,
        unit: Mapping[str, str] | None = None,
        stop_time: float | None = None,
        step_size: float | None = None,
        inputs: str | Path | None = None,
        progress: bool | Progress = False,
    ) -> Run:
        """
        Step the system from its start to its end, in this process.

        Args:
            variant: One of `variants`; None for the file as it is.
            set: `instance.parameter` (or start value, or unconnected input) to value.
            unit: Units of these values where they are not the variables' own: `{"force_sensor.T_f": "ms"}`.
            stop_time: End [s] instead of the file's.
            step_size: Length of a tick [s] instead of the file's.
            inputs: A recording (CSV, Parquet, NPZ, MAT) whose columns drive free inputs of the same name,
                as `--inputs` does; it is read for each run.
            progress: True for a bar, or a function that is called with the share that is done, 0 to 1.

        Returns:
            The run; `status` says whether it went to its end or diverged.

        Raises:
            ConfigError: With all faults of the request.
            FmuError: If an FMU fails; the attribute `run` has what was computed before.
            KeyboardInterrupt: If the run was interrupted.
        """
        values = self._in_own_units(set or {}, unit or {})
        experiment = self._prepare(self._request(variant, values, stop_time, step_size, inputs))
        with WORKING, _shown(progress, experiment) as advance:
            outcome = simulate(
                experiment.system,
                experiment.schedule,
                experiment.grid,
                options=_options(experiment),
                factory=self._slave,
                progress=advance,
            )
        if outcome.status == INTERRUPTED:
            raise KeyboardInterrupt
        run = Run(experiment, outcome, values)
        if outcome.status == FAILED and outcome.error is not None:
            outcome.error.run = run  # type: ignore[attr-defined]  # for who wants the rows before it
            raise outcome.error
        return run

    def sweep(
        self,
        values: Mapping[str, Iterable[Any]],
        *,
        unit: Mapping[str, str] | None = None,
        variant: str | None = None,
        set: Values | None = None,
        stop_time: float | None = None,
        step_size: float | None = None,
    ) -> Iterator[Run]:
        """
        Run with every combination of values, the last one varying fastest; each run when it is asked for.

        Args:
            values: `instance.parameter` to the values it takes, in `unit` or its own unit.
            unit: As for `run`, for `values` and `set`.
            variant: As for `run`.
            set: As for `run`, the same in all runs.
            stop_time: As for `run`.
            step_size: As for `run`.

        Yields:
            Runs, whose attribute `values` says what was set, in the variables' own units.

        Raises:
            ConfigError: With all faults of all combinations, before the first run.
            FmuError: If an FMU fails.
        """
        combinations = [
            {**(set or {}), **dict(zip(values, chosen, strict=True))}
            for chosen in itertools.product(*(list(v) for v in values.values()))
        ]
        problems: list[Problem] = []
        for combination in combinations:
            try:
                own = self._in_own_units(combination, unit or {})
                self._prepare(self._request(variant, own, stop_time, step_size))
            except ConfigError as error:
                problems += error.problems
        if problems:
            raise ConfigError(problems)
        return (
            self.run(variant, set=c, unit=unit, stop_time=stop_time, step_size=step_size)
            for c in combinations
        )

    def open(
        self,
        variant: str | None = None,
        *,
        set: Values | None = None,
        unit: Mapping[str, str] | None = None,
        stop_time: float | None = None,
        step_size: float | None = None,
    ) -> Simulation:
        """
        Load the FMUs and stay at the start, to step by hand; use it in a `with` block.

        Arguments as for `run`. Several may be open at a time.

        Raises:
            ConfigError: With all faults of the request.
            FmuError: If an FMU cannot be loaded or initialised.
        """
        values = self._in_own_units(set or {}, unit or {})
        experiment = self._prepare(self._request(variant, values, stop_time, step_size))
        opened = OpenRun(
            experiment.system, experiment.schedule, experiment.grid, _options(experiment), self._slave
        )
        return Simulation(experiment, opened, values)

    def experiment(self, variant: str | None = None, *, set: Values | None = None) -> Experiment:
        """Return what the master works on: the checked, ordered system; for who needs its parts."""
        return self._prepare(self._request(variant, self._in_own_units(set or {}, {}), None, None))

    def require_fmus(self, what: str) -> None:
        """
        Refuse a system with Python blocks for work that needs FMU files.

        Raises:
            ConfigError: With each block.
        """
        if self._blocks:
            raise ConfigError(
                Problem(f"{what} needs FMU files", where=name, got="a Python block", expected="an FMU")
                for name in self._blocks
            )

    def _read(self, source: Source) -> Path | LoadedConfig:
        if isinstance(source, Mapping):
            return self._within(_of_dict(source, self._blocks))
        if not isinstance(source, str | Path):
            expected = "a name, a path or a dict"
            raise ConfigError([Problem("not a system", where="load", got=repr(source), expected=expected)])
        path = configuration(source)
        if path.suffix.lower() in SUFFIXES:
            if self._blocks:
                expected = "a YAML file or a dict"
                raise ConfigError([Problem("no blocks in an SSP", where=str(path), expected=expected)])
            return path
        return self._within(read_config(path))

    def _within(self, loaded: LoadedConfig) -> LoadedConfig:
        """Check that each block takes the place of an instance."""
        known = loaded.document.names_in("fmus") or list(loaded.config.fmus)
        problems = [
            Problem("no such instance", where=f"blocks: {name}", expected=nearest(name, known))
            for name in self._blocks
            if name not in known
        ]
        if problems:
            raise ConfigError([*loaded.problems, *problems])
        return loaded

    def _prepare(self, request: Request) -> Experiment:
        if request in self._prepared:
            return self._prepared[request]
        given = {name: block.description(name) for name, block in self._blocks.items()}
        try:
            experiment = prepare_to_run(self._source, request, silent, given)
        except ConfigError as error:
            raise ConfigError(map(_without_dashes, error.problems)) from None
        self._unpack(experiment)
        if request.inputs is None:  # a recording may change between two runs
            self._prepared[request] = experiment
        return experiment

    def _unpack(self, experiment: Experiment) -> None:
        for name, instance in experiment.system.instances.items():
            d = instance.description
            if name not in self._blocks and d.can_share_library and d.path not in self._folders:
                self._folders[d.path] = unpacked.acquire(d, unpacked.unpack)

    def _request(
        self,
        variant: str | None,
        values: Values,
        stop_time: float | None,
        step_size: float | None,
        inputs: str | Path | None = None,
    ) -> Request:
        assignments = tuple(f"{name}={json.dumps(plain(value))}" for name, value in values.items())
        recording = None if inputs is None else Path(inputs)
        return Request(variant, assignments, stop_time, step_size, self._flavour, inputs=recording)

    def _in_own_units(self, values: Values, units: Mapping[str, str]) -> dict[str, Any]:
        """Convert values that are given in other units to those of their variables."""
        found = {name: plain(value) for name, value in values.items()}
        problems: list[Problem] = []
        for name, given in units.items():
            where = f"unit {name}"
            if name not in found:
                problems.append(Problem("of nothing that is set", where=where, expected=nearest(name, found)))
                continue
            try:
                own = self._experiment.system.port(name).variable.unit
                change = conversion(unit_of_name(given), own)
            except KeyError:
                continue  # the signal is refused with the others
            except ValueError as error:
                problems.append(Problem(f"not a unit: {error}", where=where, got=repr(given)))
                continue
            if change is None or own is None:
                expected = "no unit" if own is None else f"one as {own.name}"
                problems.append(Problem("another quantity", where=where, got=given, expected=expected))
                continue
            value = found[name]
            if isinstance(value, bool) or not isinstance(value, int | float):
                problems.append(Problem("no unit for it", where=where, got=repr(value), expected="a number"))
                continue
            found[name] = change.of(float(value))
        if problems:
            raise ConfigError(problems)
        return found

    def _slave(self, name: str, description: Description) -> Slave:
        return BlockSlave(name, self._blocks[name]) if name in self._blocks else load_fmu(name, description)

    def __repr__(self) -> str:
        parts = ", ".join(self.fmus)
        variants = ", ".join(self.variants) or "none"
        return f"<System {self.name}: {parts}; {len(self.connections)} connections; variants: {variants}>"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{escape(d['from'])}</td><td>{escape(d['to'])}</td><td>{d['steps']:g}</td>"
            f"<td>{1e3 * d['seconds']:.3f}</td></tr>"
            for d in self.delays()
        )
        head = "<tr><th>from</th><th>to</th><th>delay [steps]</th><th>delay [ms]</th></tr>"
        parts = ", ".join(map(escape, self.fmus))
        variants = ", ".join(map(escape, self.variants)) or "none"
        return f"<b>{escape(self.name)}</b>: {parts}<br>variants: {variants}<table>{head}{rows}</table>"


def analyse(system: System | Source, variant: str | None = None, *, set: Values | None = None) -> Any:
    """
    Linearise the coupled, scheduled system and judge it.

    Args:
        system: A system, or what `load` takes.
        variant: As for `System.run`.
        set: As for `System.run`.

    Returns:
        `master.analysis.summary.Analysis`: poles, dominant pole (`zeta`, `frequency` [Hz]), growth_rate
        [1/s], margins of every connection, latency_budget, notes; `as_dict()` is what `--json` prints.

    Raises:
        ConfigError: If the request is wrong, or the system has Python blocks.
        FmuError: If an FMU fails.
    """
    from master.analysis.closed_loop.linearise import Linearisation
    from master.analysis.summary import judge

    system = system if isinstance(system, System) else load(system)
    system.require_fmus("analyse")
    with WORKING:
        linearisation = Linearisation(system.experiment(variant, set=set), after_run=True)
        return judge(linearisation.coupled(), linearisation)


def write_ssp(
    system: System | Source, path: str | Path, variant: str | None = None, *, set: Values | None = None
) -> Path:
    """
    Write a system with its FMUs as an SSP 1.0 archive, which `load` reads back.

    Raises:
        ConfigError: With each part that an SSP cannot hold, such as a Python block.
    """
    from master.ssp.export import write_ssp as write

    system = system if isinstance(system, System) else load(system)
    system.require_fmus("an SSP")
    return write(system.experiment(variant, set=set), Path(path))


def _of_dict(source: Mapping[str, Any], blocks: dict[str, Block]) -> LoadedConfig:
    """Read a dict as the YAML of the same content; blocks in it are taken out."""
    import yaml

    content = dict(source)
    fmus = content.get("fmus")
    if isinstance(fmus, Mapping):
        content["fmus"] = {
            name: _taken_out(str(name), entry, blocks) if isinstance(entry, Mapping | Block) else entry
            for name, entry in fmus.items()
        }
    text = yaml.safe_dump(plain(content), sort_keys=False, allow_unicode=True, width=10**6)
    found = validate(Config, parse_yaml(text, Path("dict")), "system")
    if found.model is None:
        raise ConfigError(found.problems)
    return LoadedConfig(found.model, found.document, found.problems)


def _taken_out(name: str, entry: Mapping[str, Any] | Block, blocks: dict[str, Block]) -> dict[str, Any]:
    entry = {"source": entry} if isinstance(entry, Block) else dict(entry)
    if isinstance(entry.get("source"), Block):
        blocks.setdefault(name, entry["source"])
        entry["source"] = _BLOCK
    return entry


def _options(experiment: Experiment) -> RunOptions:
    return RunOptions(
        limits=experiment.limits,
        compared=experiment.compared,
        scenario=experiment.scenario,
        inputs=experiment.inputs,
    )


class _shown:  # noqa: N801  # used as a function
    """Show the progress of a run; the context is what the run calls with the ticks done."""

    def __init__(self, progress: bool | Progress, experiment: Experiment) -> None:
        self._progress = progress
        self._total = experiment.grid.n_ticks
        self._title = experiment.title
        self._done = 0
        self._bar: Any = None

    def __enter__(self) -> Callable[[int], None]:
        if self._progress is True:
            from rich.progress import Progress as Bar

            self._bar = Bar(transient=True)
            self._bar.start()
            self._task = self._bar.add_task(self._title, total=self._total)
        return self._advance

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    def _advance(self, ticks: int) -> None:
        self._done += ticks
        if self._bar is not None:
            self._bar.update(self._task, completed=self._done)
        elif callable(self._progress):
            self._progress(self._done / self._total)


def _without_dashes(problem: Problem) -> Problem:
    """Name a place as a program does: `set a.b` instead of `--set a.b`."""
    where = problem.where.removeprefix("--")
    return Problem(problem.what, where=where, got=problem.got, expected=problem.expected)


def _release(folders: dict[Path, str]) -> None:
    for folder in folders.values():
        unpacked.release(folder)
    folders.clear()
