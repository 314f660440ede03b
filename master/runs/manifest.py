"""The manifest of a run: what it was made of, where and when, so that it can be repeated and judged."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from master.errors import DataError
from master.experiment.experiment import Experiment
from master.experiment.prepare import Request
from master.installation import IS_CHECKOUT, SHIPPED
from master.recording.folder import CSV, MANIFEST, PARQUET, PARTS
from master.recording.whole_file import write_whole
from master.ssp.names import SUFFIXES

from .hashes import sha256

FORMAT = 1
RUNNING = "running"
"""Status in the manifest of a run that goes on, or was killed."""
GIVEN = "--inputs"
"""Name of the table that the command gives."""
_PACKAGES = ("numpy", "numba", "pyarrow")


class _Part(BaseModel):
    """Base of the manifest's parts; keys that a later version adds are kept out of the way."""

    model_config = ConfigDict(extra="ignore", frozen=True)


class HashedFile(_Part):
    """A file by its path (None: within an archive), and its SHA-256 (None: it could not be read)."""

    path: str | None
    sha256: str | None


class HashedFmu(HashedFile):
    """An FMU's file and the `source` that the configuration names."""

    source: str


class Asked(_Part):
    """What the run was asked for in addition to its file; see `Request`."""

    variant: str | None = None
    assignments: tuple[str, ...] = ()
    stop_time: float | None = None
    step_size: float | None = None
    flavour: str = "native"
    record: tuple[str, ...] = ()
    every: int | None = None
    inputs: Path | None = None
    isolate: tuple[str, ...] = ()
    sandbox: bool = False

    def request(self) -> Request:
        """Return it as a request."""
        return Request(**self.model_dump())


class Checkpointing(_Part):
    """How a run makes checkpoints, each `interval` [s], and what `resume` needs to know to end it alike."""

    interval: float
    log: str | None = None
    page: bool = False


class Resumption(_Part):
    """From which tick a run went on, and when."""

    tick: int
    started: str


class Manifest(_Part):
    """
    What a run was made of.

    `configuration` is as it was given (a name or a path) and as a file; `set` of `asked` are `assignments`.
    `seeds` are those of FMUs (parameters whose names contain `seed`) and of events, `results` the hashes of
    the result files, `duration` the time of the whole run with its saving [s], pauses before it was resumed
    included. While a run goes on its `status` is `running`; `checkpoints` says how it can be resumed, and
    `resumed` how often it was.
    """

    format: int
    command: tuple[str, ...]
    given: str
    configuration: HashedFile
    asked: Asked
    dockloop: dict[str, Any]
    fmus: dict[str, HashedFmu]
    inputs: dict[str, HashedFile]
    seeds: dict[str, int]
    machine: dict[str, Any]
    started: str
    duration: float
    status: str
    steps: int
    results: dict[str, str]
    checkpoints: Checkpointing | None = None
    resumed: tuple[Resumption, ...] = ()


@dataclass(frozen=True)
class Ingredients:
    """What goes into a run: the hashes of its files, and its seeds."""

    configuration: HashedFile
    fmus: dict[str, HashedFmu]
    inputs: dict[str, HashedFile]
    seeds: dict[str, int]


@dataclass
class Described:
    """
    A run that is going on, as its manifest will describe it.

    `given` is the configuration as the user named it, `path` its file.
    """

    given: str
    path: Path
    request: Request
    experiment: Experiment
    started: datetime = field(default_factory=lambda: datetime.now(UTC))
    checkpoints: Checkpointing | None = None
    resumed: tuple[Resumption, ...] = ()
    _ingredients: Ingredients | None = None

    def look(self) -> Ingredients:
        """Hash what goes into the run; once, however often it is called."""
        if self._ingredients is None:
            self._ingredients = ingredients(self.path, self.experiment, self.request.inputs)
            _program()
        return self._ingredients

    def manifest(self, status: str, steps: int, folder: Path) -> Manifest:
        """Describe the run when its results are in a folder."""
        found = self.look()
        return Manifest(
            format=FORMAT,
            command=command(self.given, self.request),
            given=self.given,
            configuration=found.configuration,
            asked=_asked(self.request),
            dockloop=_program(),
            fmus=found.fmus,
            inputs=found.inputs,
            seeds=found.seeds,
            machine=_machine(),
            started=self.started.isoformat(timespec="milliseconds"),
            duration=(datetime.now(UTC) - self.started).total_seconds(),
            status=status,
            steps=steps,
            results={} if status == RUNNING else result_hashes(folder),
            checkpoints=self.checkpoints,
            resumed=self.resumed,
        )


def ingredients(path: Path, experiment: Experiment, given: Path | None = None) -> Ingredients:
    """Hash what goes into a run; `given` is the table of `--inputs`, which no archive holds."""
    is_archive = path.suffix.lower() in SUFFIXES
    fmus: dict[str, HashedFmu] = {}
    for name, instance in experiment.system.instances.items():
        file = instance.description.path
        shown = None if is_archive else str(file.absolute())
        fmus[name] = HashedFmu(path=shown, sha256=_hash(file), source=experiment.config.fmus[name].source)
    inputs: dict[str, HashedFile] = {}
    for name, file in experiment.inputs.files.items():
        is_given = given is not None and name == str(given)
        shown = None if is_archive and not is_given else str(file.absolute())
        inputs[GIVEN if is_given else name] = HashedFile(path=shown, sha256=_hash(file))
    configuration = HashedFile(path=str(path.absolute()), sha256=_hash(path))
    return Ingredients(configuration, fmus, inputs, _seeds(experiment))


def _hash(path: Path) -> str | None:
    try:
        return sha256(path)
    except OSError:
        return None


def command(given: str, request: Request) -> tuple[str, ...]:
    """Words of the command that makes a run."""
    words = ["dockloop", "run", given]
    if request.variant is not None:
        words += ["--variant", request.variant]
    for assignment in request.assignments:
        words += ["--set", assignment]
    if request.stop_time is not None:
        words += ["--stop-time", repr(request.stop_time)]
    if request.step_size is not None:
        words += ["--step-size", repr(request.step_size)]
    if request.flavour != "native":
        words += ["--flavour", request.flavour]
    for signal in request.record:
        words += ["--record", signal]
    if request.every is not None:
        words += ["--every", str(request.every)]
    if request.inputs is not None:
        words += ["--inputs", str(request.inputs)]
    for names in request.isolate:
        words += ["--isolate", names]
    if request.sandbox:
        words.append("--sandbox")
    return tuple(words)


def result_hashes(folder: Path) -> dict[str, str]:
    """Hash the result files that are in a folder."""
    names = [CSV, PARQUET, *sorted(part.name for part in folder.glob(PARTS))]
    return {name: sha256(folder / name) for name in names if (folder / name).is_file()}


def write_manifest(manifest: Manifest, folder: Path) -> Path:
    """
    Write a manifest into the folder of its run.

    Raises:
        OSError: If it cannot be written; there is none then.
    """
    path = folder / MANIFEST
    text = json.dumps(manifest.model_dump(mode="json"), indent=2) + "\n"
    write_whole(path, text, is_durable=manifest.checkpoints is not None)
    return path


def read_manifest(folder: Path) -> Manifest:
    """
    Read the manifest of a results folder.

    Raises:
        DataError: If there is none, or it is damaged or of another format.
    """
    path = folder / MANIFEST
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        expected = "the results folder of a run"
        raise DataError(f"{folder}: no {MANIFEST}, expected {expected}") from None
    except (OSError, ValueError) as error:
        raise DataError(f"{path}: cannot be read as a manifest: {error}") from None
    if isinstance(content, dict) and content.get("format") != FORMAT:
        raise DataError(f"{path}: format, got {content.get('format')!r}, expected {FORMAT}")
    try:
        return Manifest.model_validate(content)
    except ValidationError as error:
        places = ", ".join(".".join(map(str, e["loc"])) or "the whole" for e in error.errors())
        raise DataError(f"{path}: not a manifest, got faults at {places}") from None


def _asked(request: Request) -> Asked:
    """What was asked for, with a path that holds in any folder."""
    inputs = None if request.inputs is None else request.inputs.absolute()
    return Asked(**asdict(replace(request, inputs=inputs)))


def _seeds(experiment: Experiment) -> dict[str, int]:
    seeds: dict[str, int] = {}
    for name, instance in experiment.system.instances.items():
        for variable in instance.description.variables:
            if variable.causality in ("parameter", "structuralParameter") and "seed" in variable.name.lower():
                value = instance.value_of(variable.name)
                if isinstance(value, int | float) and float(value).is_integer():
                    seeds[f"{name}.{variable.name}"] = int(value)
    for i, event in enumerate(experiment.config.events):
        if event.jitter:
            seeds[f"events[{i}]"] = int(event.seed)
    return seeds


@cache
def _program() -> dict[str, Any]:
    """Version of dockloop; in a checkout the commit, and whether files differ from it."""
    found: dict[str, Any] = {"version": _version("dockloop")}
    if IS_CHECKOUT:
        commit = _git("rev-parse", "HEAD")
        changed = _git("status", "--porcelain", "--untracked-files=no")
        found |= {"commit": commit, "modified": None if changed is None else bool(changed)}
    return found


def _git(*words: str) -> str | None:
    """Output of a git command in the checkout; None where git or its folder is missing."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("GIT_")}
    try:
        done = subprocess.run(
            ["git", "--no-optional-locks", "-C", str(SHIPPED), *words],
            capture_output=True,
            text=True,
            check=True,
            timeout=10.0,
            env=environment,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()


def _machine() -> dict[str, Any]:
    packages = {name: _version(name) for name in _PACKAGES}
    return {
        "platform": platform.platform(),
        "processor": platform.machine(),
        "python": sys.version.split()[0],
    } | (packages)


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
